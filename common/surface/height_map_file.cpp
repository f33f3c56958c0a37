// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/height_map.h"
#include "basics/error.h"
#include "basics/image_file.h"
#include "basics/progress.h"
#include "surface/map_image.h"
#include "surface/map_selection.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>
#include <strings.h>
#include <unistd.h>

namespace programs {
namespace {

/* Redirects stderr of all threads to /dev/null, because libpng prints errors that OpenImageIO reports anyway. */
class QuietStderr {
public:
  QuietStderr() : saved(dup(STDERR_FILENO)) {
    std::fflush(stderr);
    const int nowhere = open("/dev/null", O_WRONLY);
    if (saved >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) close(nowhere);
  }
  ~QuietStderr() {
    if (saved < 0) return;
    std::fflush(stderr);
    dup2(saved, STDERR_FILENO);
    close(saved);
  }

private:
  int saved;
};

constexpr const char* recipeAttribute = "recipe";
constexpr const char* heightChannel = "height";

Error unreadable(const std::string& path, std::string reason) {
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  for (char& c : reason)
    if (c == '\n') c = ' ';
  return Error(path + ": cannot read this height map: " + (reason.empty() ? "unknown reason" : reason));
}

/* True for names of a first tile, and for placeholders of other programs. */
bool resemblesTile(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  const char* const parts[] = {"<", "%(", "u1_v1", "u0_v0", "1001"};
  return std::any_of(std::begin(parts), std::end(parts),
                     [&](const char* part) { return name.find(part) != std::string::npos; });
}

/* Pipes without a writer would block, and OpenImageIO opens a file several times. */
void requireFile(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (!std::filesystem::exists(status))
    throw Error(path + ": no such height map" +
                (resemblesTile(path) ? "; expected <UDIM>, %(UDIM)d or <UVTILE> for tiles" : ""));
  if (!std::filesystem::is_regular_file(status) && !std::filesystem::is_directory(status))
    throw Error(path + ": this is a pipe or a device, which cannot be read more than once: expected a file");
}

std::unique_ptr<MapImage> openImage(const std::string& path) {
  requireFile(path);
  const std::string extension = std::filesystem::path(path).extension().string();
  const std::string formats = "," + std::string(OIIO::get_string_attribute("input_format_list")) + ",";
  if ((extension == ".ptx" || extension == ".ptex") && formats.find(",ptex,") == std::string::npos)
    throw Error(path + ": this OpenImageIO has no Ptex reader: expected another format, such as a TIFF "
                       "with one page per face");
  auto input = std::make_unique<MapImage>();
  OIIO::ImageSpec spec;
  if (!input->open(path, spec, MapImage::configuration({}))) throw unreadable(path, input->geterror());
  return input;
}

struct Texels {
  int width, height, channels;
  std::vector<float> values;

  const float* at(int x, int y) const { return &values[(size_t(y) * size_t(width) + size_t(x)) * size_t(channels)]; }

  /* True if adjacent copies of the map meet without a step. */
  bool hasConstantBorder() const {
    const auto same = [&](int x, int y) { return std::equal(at(x, y), at(x, y) + channels, at(0, 0)); };
    for (int x = 0; x < width; x++)
      if (!same(x, 0) || !same(x, height - 1)) return false;
    for (int y = 0; y < height; y++)
      if (!same(0, y) || !same(width - 1, y)) return false;
    return true;
  }
};

bool isCanceled(void*, float) { return cancelRequested(); }

Texels readImage(MapImage& input, int image, int first, int count, const std::string& path) {
  const OIIO::ImageSpec& spec = input.spec();
  Texels texels{spec.width, spec.height, count, {}};
  texels.values.resize(size_t(spec.width) * size_t(spec.height) * size_t(count));
  const bool read = input.read_image(image, 0, first, first + count, OIIO::TypeDesc::FLOAT, texels.values.data(),
                                     OIIO::AutoStride, OIIO::AutoStride, OIIO::AutoStride, isCanceled);
  throwIfCanceled();
  if (!read) throw unreadable(path, input.geterror());
  const auto bad = std::find_if(texels.values.begin(), texels.values.end(), [](float x) { return !std::isfinite(x); });
  if (bad == texels.values.end()) return texels;
  const size_t texel = size_t(bad - texels.values.begin()) / size_t(count), width = size_t(spec.width);
  throw Error(path + ": the " + (count == 1 ? "height" : "vector") + " at texel " + std::to_string(texel % width) +
              "," + std::to_string(texel / width) + (image ? " of image " + std::to_string(image) : "") +
              " is not finite: expected a finite number");
}

bool isAlpha(const OIIO::ImageSpec& spec, int channel) {
  const std::string& name = spec.channelnames[size_t(channel)];
  const std::string suffix = name.substr(name.rfind('.') + 1); // npos + 1 is 0
  return channel == spec.alpha_channel || strcasecmp(suffix.c_str(), "A") == 0 ||
         strcasecmp(suffix.c_str(), "Alpha") == 0;
}

/* OpenImageIO sorts the channels of OpenEXR: alpha precedes, for example, a channel named Height. */
int defaultChannel(const OIIO::ImageSpec& spec, int count) {
  for (int first = 0; count == 1 && first < spec.nchannels; first++)
    if (strcasecmp(spec.channelnames[size_t(first)].c_str(), heightChannel) == 0) return first;
  for (int first = 0, end = 0; end < spec.nchannels; end++)
    if (isAlpha(spec, end)) first = end + 1;
    else if (end - first + 1 == count) return first;
  return 0;
}

/* Returns the channel's index, or -1 unless `count` channels start there. */
int findChannel(const MapImage& input, const std::string& channel, int count) {
  const OIIO::ImageSpec& spec = input.spec();
  int first = channel.empty() ? defaultChannel(spec, count) : channelNumber(spec.channelnames, channel);
  const std::string part = input.partName() + ".";
  if (first < 0 && channel.compare(0, part.size(), part) == 0)
    first = channelNumber(spec.channelnames, channel.substr(part.size()));
  return first <= spec.nchannels - count ? first : -1;
}

std::string channelsOf(const MapImage& input) {
  return listOfChannels(input.spec().channelnames) +
         (input.partName().empty() ? "" : " (part " + input.partName() + ")");
}

[[noreturn]] void throwUnknownChannel(const std::string& path, const std::string& channel, int count,
                                      const std::string& names) {
  if (count > 1)
    throw Error(path + ": a map of vectors needs " + std::to_string(count) + " channels" +
                (channel.empty() ? "" : " from '" + channel + "' on") + ": expected them among " + names);
  throw Error(path + ": unknown channel '" + channel + "': expected one of " + names);
}

} // namespace

HeightMap HeightMap::read(const std::string& path) {
  const QuietStderr quiet;
  const auto input = openImage(path);
  const int channel = findChannel(*input, "", 1);
  input->setChannelRange({channel, 1, NAN}); // a missing height is an error
  Texels texels = readImage(*input, 0, channel, 1, path);
  HeightMap map;
  map.w = texels.width;
  map.h = texels.height;
  map.texels = std::move(texels.values);
  return map;
}

HeightMap::FileInfo HeightMap::inspect(const std::string& path, const std::string& channel, int count, float neutral) {
  const QuietStderr quiet;
  const auto input = openImage(path);
  FileInfo info;
  std::string otherChannels; // of parts that are left out
  for (int number = 0; input->seek_subimage(number, 0); number++) {
    info.firstChannels.push_back(0);
    if (input->isCopyOrMask()) continue;
    const int first = findChannel(*input, channel, count);
    if (first < 0) {
      otherChannels += (otherChannels.empty() ? "" : "; ") + channelsOf(*input);
      if (!input->hasParts()) throwUnknownChannel(path, channel, count, otherChannels);
      continue;
    }
    info.numbers.push_back(number);
    info.firstChannels.back() = first;
    input->setChannelRange({first, count, neutral});
    const Texels texels = readImage(*input, number, first, count, path);
    info.isTextureReadable &= input->isTextureReadable();
    if (const int tile = input->tileSize(); tile > 0)
      info.tileSize = info.tileSize > 0 ? std::min(info.tileSize, tile) : tile;
    if (info.images++ > 0) continue;
    info.channels = input->spec().nchannels;
    info.constantBorder = texels.hasConstantBorder();
  }
  if (!input->rejection().empty())
    throw unreadable(path, "image " + std::to_string(input->current_subimage()) + ": " + input->rejection());
  if (info.images == 0 && !otherChannels.empty()) throwUnknownChannel(path, channel, count, otherChannels);
  if (info.images == 0)
    throw unreadable(path, "it contains only smaller copies or masks: expected at least one other image");
  info.missing = input->numMissing();
  info.isTextureReadable &= info.missing == 0;
  return info;
}

std::string HeightMap::recipeOf(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return "";
  const QuietStderr quiet;
  const auto input = OIIO::ImageInput::open(path);
  if (input) return std::string(input->spec().get_string_attribute(recipeAttribute));
  OIIO::geterror(); // otherwise OpenImageIO prints it later
  return "";
}

void HeightMap::write(const std::string& path, const std::string& recipe) const {
  OIIO::ImageSpec spec(w, h, 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {heightChannel};
  spec.attribute("compression", "none"); // noise hardly compresses
  if (!recipe.empty()) spec.attribute(recipeAttribute, recipe);
  writeImageFile(path, spec, OIIO::TypeDesc::FLOAT, texels.data());
}

} // namespace programs
