// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/height_texture.h"
#include "basics/error.h"
#include "surface/height_map.h"

#include <OpenImageIO/imageio.h>
#include <OpenImageIO/texture.h>

namespace cbvh {
namespace {

constexpr int tileSize = 64; // of files that have no tiles

} // namespace

struct HeightTexture::Implementation
{
  OIIO::TextureSystem* system = nullptr;
  OIIO::TextureSystem::TextureHandle* handle = nullptr;
  OIIO::TextureOpt options;

  ~Implementation()
  {
    if (system)
      OIIO::TextureSystem::destroy(system);
  }
};

HeightTexture::HeightTexture(const std::string& path, TextureWrap wrap)
  : implementation(std::make_unique<Implementation>())
{
  const HeightMap::FileInfo info = HeightMap::inspect(path);
  images = info.images;
  constantBorder = info.constantBorder;
  /* A system of its own: its cache goes with it. Texels stay in the file's type, so mip
   * levels are rounded to it: with "forcefloat" 2.4.7 runs into an assertion of its own. */
  OIIO::TextureSystem* system = implementation->system = OIIO::TextureSystem::create(false);
  system->attribute("automip", 1);     // mip levels of files that have none
  system->attribute("autotile", tileSize);   // and tiles
  system->attribute("max_memory_MB", 4096.0f);
  implementation->handle = system->get_texture_handle(OIIO::ustring(path));
  if (!implementation->handle || !system->good(implementation->handle))
    throw Error(path + ": OpenImageIO makes no texture of it: " + system->geterror());
  OIIO::TextureOpt& options = implementation->options;
  options.swrap = options.twrap =
    wrap == TextureWrap::Repeat ? OIIO::TextureOpt::WrapPeriodic : OIIO::TextureOpt::WrapClamp;
  options.mipmode = OIIO::TextureOpt::MipModeTrilinear;
  options.interpmode = OIIO::TextureOpt::InterpSmartBicubic;
  fillCache();
}

/* Touches every tile of every mip level, so that the first build is not the one that
 * pays for reading the file. */
void HeightTexture::fillCache() const
{
  for (unsigned image = 0; image < images; image++)
  {
    int size[2] = {0, 0};
    implementation->system->get_texture_info(implementation->handle, nullptr, int(image), OIIO::ustring("resolution"),
                                             OIIO::TypeDesc(OIIO::TypeDesc::INT, 2), size);
    for (int w = size[0], h = size[1]; w > 0 && h > 0; w /= 2, h /= 2)
      for (int y = 0; y < h; y += tileSize)
        for (int x = 0; x < w; x += tileSize)
          sample(image, (float(x) + 0.5f) / float(w), (float(y) + 0.5f) / float(h), 1.0f / float(w), 1.0f / float(h));
  }
}

HeightTexture::~HeightTexture() = default;

float HeightTexture::sample(unsigned image, float s, float t, float widthS, float widthT) const
{
  OIIO::TextureOpt options = implementation->options; // the call writes into it
  options.subimage = int(image);
  float height = 0.0f;
  implementation->system->texture(implementation->handle, implementation->system->get_perthread_info(), options, s, t,
                                  widthS, 0.0f, 0.0f, widthT, 1, &height);
  return height;
}

} // namespace cbvh
