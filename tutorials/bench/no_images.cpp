// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cbvh_bench_bare links this file before the files of common/ that need OpenImageIO. Generated scenes then keep
 * their height maps in memory. */

#include "basics/error.h"
#include "pictures/image_output.h"
#include "surface/height_map.h"
#include "surface/height_texture.h"

namespace programs {
namespace {

[[noreturn]] void rejectImage(const std::string& path) {
  throw Error(path + ": cbvh_bench_bare has no OpenImageIO to read or write images: expected cbvh_bench");
}

} // namespace

HeightMap HeightMap::read(const std::string& path) { rejectImage(path); }
HeightMap::FileInfo HeightMap::inspect(const std::string& path, const std::string&, int, float) { rejectImage(path); }

/* Maps are not cached. */
void HeightMap::write(const std::string&, const std::string&) const {}
std::string HeightMap::recipeOf(const std::string&) { return ""; }

struct HeightTexture::Implementation {};
HeightTexture::HeightTexture(const std::vector<std::string>& paths, const TextureChannels&, TextureWrap, std::string&) {
  rejectImage(paths.front());
}
HeightTexture::~HeightTexture() = default;
bool HeightTexture::looksLikeNormals() const { return false; }
void HeightTexture::texels(unsigned, int, int, int, float*) const {}
void HeightTexture::sample(unsigned, float, float, float, float, float*) const {}

void writePng(const std::string& path, const Image&) { rejectImage(path); }

} // namespace programs
