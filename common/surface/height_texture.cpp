// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/height_texture.h"
#include "basics/error.h"
#include "basics/progress.h"
#include "surface/height_map.h"
#include "surface/map_image.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/texture.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <thread>

namespace programs {
namespace {

constexpr int tileSize = 64; // for files without tiles

struct TextureImage {
  OIIO::TextureSystem::TextureHandle* handle = nullptr;
  OIIO::ustring path;
  int subimage = 0;
  int firstChannel = 0;
};

/* Pointers in OpenImageIO 2, shared pointers in OpenImageIO 3. */
using ImageCache = decltype(OIIO::ImageCache::create(false));
using TextureSystem = decltype(OIIO::TextureSystem::create(false));

/* OpenImageIO's state of a thread, mainly its last tiles. The texture owns all states: OpenImageIO frees its own state
 * of a thread when the thread ends, which crashes if another thread destroys the texture meanwhile. */
class ThreadStates {
public:
  /* Calls body(state) with a state that no other thread uses meanwhile, usually the same for the same thread. */
  template<typename Body>
  void use(OIIO::TextureSystem* system, const Body& body) {
    static std::atomic<unsigned> numThreads{0};
    thread_local const unsigned number = numThreads++;
    for (unsigned i = number;; i++) {
      Slot& slot = slots[i % slots.size()];
      const std::unique_lock<std::mutex> lock(slot.mutex, std::try_to_lock);
      if (lock) {
        if (!slot.state) slot.state = system->create_thread_info();
        body(slot.state);
        return;
      }
      if (i - number >= slots.size()) std::this_thread::yield();
    }
  }

  void destroy(OIIO::TextureSystem* system) {
    for (Slot& slot : slots)
      if (slot.state) system->destroy_thread_info(slot.state);
  }

private:
  struct alignas(64) Slot // its own cache line
  {
    std::mutex mutex;
    OIIO::TextureSystem::Perthread* state = nullptr;
  };

  std::array<Slot, 256> slots; // threads that use states at the same time; more threads wait
};

OIIO::TextureOpt::Wrap wrapOf(TextureWrap wrap) {
  switch (wrap) {
  case TextureWrap::Repeat: return OIIO::TextureOpt::WrapPeriodic;
  case TextureWrap::Black: return OIIO::TextureOpt::WrapBlack;
  default: return OIIO::TextureOpt::WrapClamp;
  }
}

} // namespace

struct HeightTexture::Implementation {
  ImageCache cache{};
  TextureSystem system{};
  mutable ThreadStates states;
  std::vector<TextureImage> images;
  OIIO::TextureOpt options;
  int channelsOfFile = 1;
  int smallestTile = tileSize; // edge

  ~Implementation() {
    if (system) {
      states.destroy(&*system);
      OIIO::TextureSystem::destroy(system);
    }
    if (cache) OIIO::ImageCache::destroy(cache);
  }

  /* `count` images of the file belong to the texture. */
  void open(const std::string& path, size_t count, const HeightMap::FileInfo& info, const TextureChannels& read) {
    if (!info.isTextureReadable) {
      const OIIO::ImageSpec config = MapImage::configuration({0, read.count, read.neutral}, info.firstChannels);
      cache->add_file(OIIO::ustring(path), [] { return static_cast<OIIO::ImageInput*>(new MapImage); }, &config);
    } else if (info.tileSize > 0) smallestTile = std::min(smallestTile, info.tileSize);
    OIIO::TextureSystem::TextureHandle* handle = nullptr;
    states.use(&*system, [&](auto* state) { handle = system->get_texture_handle(OIIO::ustring(path), state); });
    if (!handle || !system->good(handle))
      throw Error(path + ": OpenImageIO cannot use this image as a texture: " + system->geterror());
    for (size_t i = 0; i < count; i++)
      images.push_back({handle, OIIO::ustring(path), info.numbers[i], info.firstChannels[size_t(info.numbers[i])]});
  }

  Error unreadable(unsigned image) const {
    return Error(images[image].path.string() + ": OpenImageIO cannot read texels of image " +
                 std::to_string(images[image].subimage) + ": " + system->geterror());
  }

  /* Reads channels from `firstChannel` on. Returns false, with NaN in `values`, if OpenImageIO cannot read a tile. */
  bool lookUp(unsigned image, int firstChannel, float s, float t, float widthS, float widthT, int count,
              float* values) const {
    OIIO::TextureOpt opt = options;
    opt.subimage = images[image].subimage;
    opt.firstchannel = firstChannel;
    bool isRead = false;
    states.use(&*system, [&](auto* state) {
      isRead = system->texture(images[image].handle, state, opt, s, t, widthS, 0.0f, 0.0f, widthT, count, values);
    });
    if (!isRead) std::fill(values, values + count, NAN);
    return isRead;
  }

  /* Texels within the image. */
  void readTexels(unsigned image, int column, int row, int count, int channels, float* values) const {
    OIIO::TextureOpt opt = options;
    opt.subimage = images[image].subimage;
    const int first = images[image].firstChannel;
    bool isRead = false;
    states.use(&*system, [&](auto* state) {
      isRead = system->get_texels(images[image].handle, state, opt, 0, column, column + count, row, row + 1, 0, 1,
                                  first, first + channels, OIIO::TypeDesc::FLOAT, values);
    });
    if (!isRead) throw unreadable(image);
  }

  Vec2f size(unsigned image) const {
    int size[2] = {0, 0};
    bool isRead = false;
    states.use(&*system, [&](auto* state) {
      isRead = system->get_texture_info(images[image].handle, state, images[image].subimage,
                                        OIIO::ustring("resolution"), OIIO::TypeDesc(OIIO::TypeDesc::INT, 2), size);
    });
    if (!isRead || size[0] < 1 || size[1] < 1) throw unreadable(image);
    return {float(size[0]), float(size[1])};
  }
};

HeightTexture::HeightTexture(const std::vector<std::string>& paths, const TextureChannels& channels, TextureWrap wrap,
                             std::string& warnings)
  : implementation(std::make_unique<Implementation>()),
    channels(channels.count),
    wrap(wrap) {
  /* Private, so that the cache is freed. Mip levels are rounded to the file's type, because "forcefloat" fails an
   * assertion in OpenImageIO 2.4.7. */
  implementation->cache = OIIO::ImageCache::create(false);
  const TextureSystem& system = implementation->system = OIIO::TextureSystem::create(false, implementation->cache);
  system->attribute("automip", 1); // mip levels for files without them
  system->attribute("autotile", tileSize);
  system->attribute("unassociatedalpha", 1); // keep colors unmultiplied
  system->attribute("max_memory_MB", 4096.0f);
  for (const std::string& path : paths) {
    const HeightMap::FileInfo info = HeightMap::inspect(path, channels.first, channels.count, channels.neutral);
    if (path == paths.front()) {
      constantBorder = info.constantBorder;
      implementation->channelsOfFile = info.channels;
    }
    implementation->open(path, paths.size() == 1 ? info.numbers.size() : 1, info, channels);
    if (info.missing)
      warnings += path + ": " + std::to_string(info.missing) + (info.missing == 1 ? " texel has" : " texels have") +
                  " no value and " + (info.missing == 1 ? "displaces" : "displace") + " nothing\n";
  }
  images = unsigned(implementation->images.size());
  for (unsigned image = 0; image < images; image++) sizes.push_back(implementation->size(image));
  OIIO::TextureOpt& options = implementation->options;
  options.swrap = options.twrap = wrapOf(wrap);
  options.mipmode = OIIO::TextureOpt::MipModeTrilinear;
  options.interpmode = OIIO::TextureOpt::InterpBilinear; // as chart_filter.cpp
  fillCache();
}

/* Reads every tile of every mip level, to exclude file access from the time of the first build. */
void HeightTexture::fillCache() const {
  float values[4];
  const int tile = implementation->smallestTile;
  for (unsigned image = 0; image < images; image++) {
    const Vec2f texels = size(image);
    for (int w = int(texels.x), h = int(texels.y); w > 0 && h > 0; w /= 2, h /= 2)
      for (int y = 0; y < h; y += tile) {
        throwIfCanceled();
        for (int x = 0; x < w; x += tile)
          if (!implementation->lookUp(image, implementation->images[image].firstChannel, (float(x) + 0.5f) / float(w),
                                      (float(y) + 0.5f) / float(h), 1.0f / float(w), 1.0f / float(h), channels, values))
            throw implementation->unreadable(image);
      }
  }
}

HeightTexture::~HeightTexture() = default;

void HeightTexture::texels(unsigned image, int column, int row, int count, float* values) const {
  const int width = int(size(image).x), height = int(size(image).y);
  const auto wrapped = [&](int i, int n) { // -1 for black
    if (i >= 0 && i < n) return i;
    return wrap == TextureWrap::Repeat ? (i % n + n) % n : wrap == TextureWrap::Clamp ? std::clamp(i, 0, n - 1) : -1;
  };
  const int y = wrapped(row, height);
  for (int done = 0; done < count;) {
    const int x = wrapped(column + done, width);
    const bool isInside = x >= 0 && (x == column + done || wrap == TextureWrap::Repeat);
    const int run = isInside ? std::min(count - done, width - x) : 1;
    if (x < 0 || y < 0) std::fill_n(values, run * channels, 0.0f);
    else implementation->readTexels(image, x, y, run, channels, values);
    values += run * channels;
    done += run;
  }
}

bool HeightTexture::looksLikeNormals() const {
  constexpr int places = 64;        // samples along each axis
  constexpr float tolerance = 0.1f; // of a unit vector's length; the map has 8 bits and is filtered
  if (implementation->channelsOfFile < 3) return false;
  int unit = 0, along = 0;
  for (int y = 0; y < places; y++)
    for (int x = 0; x < places; x++) {
      float c[3];
      implementation->lookUp(0, 0, (float(x) + 0.5f) / places, (float(y) + 0.5f) / places, 0.0f, 0.0f, 3, c);
      const float n[3] = {2.0f * c[0] - 1.0f, 2.0f * c[1] - 1.0f, 2.0f * c[2] - 1.0f};
      unit += std::abs(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1.0f) < tolerance;
      along += n[2] > 0.5f;
    }
  constexpr int most = places * places * 9 / 10;
  return unit > most && along > most;
}

void HeightTexture::sample(unsigned image, float s, float t, float widthS, float widthT, float* values) const {
  if (!implementation->lookUp(image, implementation->images[image].firstChannel, s, t, widthS, widthT, channels,
                              values))
    implementation->system->geterror(); // the file changed after the constructor read it; errors would accumulate
}

} // namespace programs
