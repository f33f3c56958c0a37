// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* In place of all that needs OpenImageIO, for cbvh_bench_bare: it is linked before the files of
 * common/ that have it. Generated scenes keep their height maps in memory, and need none. */

#include "basics/error.h"
#include "pictures/image_output.h"
#include "surface/height_map.h"
#include "surface/height_texture.h"

namespace cbvh {
namespace {

[[noreturn]] void refuse(const std::string& path)
{
  throw Error(path + ": cbvh_bench_bare has no OpenImageIO, and neither reads nor writes images; use cbvh_bench");
}

} // namespace

HeightMap HeightMap::read(const std::string& path) { refuse(path); }
HeightMap::FileInfo HeightMap::inspect(const std::string& path, const std::string&, int, float) { refuse(path); }

/* Not kept for another run. */
void HeightMap::write(const std::string&, const std::string&) const {}
std::string HeightMap::recipeOf(const std::string&) { return ""; }

struct HeightTexture::Implementation
{
};
HeightTexture::HeightTexture(const std::vector<std::string>& paths, const TextureChannels&, TextureWrap, std::string&) { refuse(paths.front()); }
HeightTexture::~HeightTexture() = default;
Vec2f HeightTexture::size(unsigned) const { return {0, 0}; }
bool HeightTexture::looksLikeNormals() const { return false; }
void HeightTexture::sample(unsigned, float, float, float, float, float*) const {}

void writePng(const std::string& path, const Image&) { refuse(path); }

} // namespace cbvh
