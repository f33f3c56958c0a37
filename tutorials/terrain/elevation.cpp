// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "elevation.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/parallel.h"
#include "basics/setting_name.h"
#include "scenes/noise.h"
#include "surface/map_selection.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

namespace programs {
namespace {

/* Features are 256 to 4 samples wide; each octave is half as high as the previous one. */
constexpr float longestWave = 256;
constexpr int octaves = 7;

/* Rows of colors that are in memory at a time. */
constexpr int decodedRows = 256;

/* Maps index i in a sequence of mirrored copies to an index in the raster of n samples. */
int mirrored(int i, int n) {
  const int period = 2 * (n - 1), index = i % period;
  return index < n ? index : period - index;
}

/* OpenImageIO would wait for a pipe's writer. */
void requireNoPipe(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && std::filesystem::is_other(status))
    throw Error(path + ": this is a pipe or a device, which cannot be read more than once: expected a file");
}

} // namespace

Elevation::Elevation(const ElevationSettings& settings) : settings(settings) {
  requireNoPipe(settings.path);
  recordInputFile(settings.path);
  openPicture();
  sourceWidth = image.spec().width;
  sourceHeight = image.spec().height;
  if (sourceWidth < 2 || sourceHeight < 2)
    throw Error(settings.path + ": the raster has " + std::to_string(sourceWidth) + " x " +
                std::to_string(sourceHeight) + " samples: expected at least 2 x 2");
  if (std::max(settings.repeatX, settings.repeatY) > 1 &&
      std::max(double(settings.repeatX) * sourceWidth, double(settings.repeatY) * sourceHeight) > 1e6)
    throw Error("invalid --height-repeat " + std::to_string(settings.repeatX) + "x" + std::to_string(settings.repeatY) +
                ": expected at most 1000000 samples along each side");
}

void Elevation::openPicture() {
  const auto native = OIIO::ImageInput::open(settings.path);
  const auto unreadable = [&](const std::string& reason) {
    return Error(settings.path + ": cannot read this elevation raster: " + reason);
  };
  OIIO::ImageSpec spec;
  if (!native || !image.open(settings.path, spec, MapImage::configuration({})))
    throw unreadable(native ? image.geterror() : OIIO::geterror());
  picture = seekPicture(image, 0);
  if (picture < 0)
    throw unreadable(image.rejection().empty()
                         ? "it contains only smaller copies or masks: expected at least one other image"
                         : "image " + std::to_string(image.current_subimage()) + ": " + image.rejection());
  if (!native->seek_subimage(picture, 0)) throw unreadable(native->geterror());
  selectChannels(native->spec().format);
}

/* Never takes one of several channels for the heights unless the caller says so. */
void Elevation::selectChannels(OIIO::TypeDesc type) {
  const OIIO::ImageSpec& spec = image.spec();
  const std::string names = listOfChannels(spec.channelnames);
  const std::string found =
      std::to_string(spec.nchannels) + (spec.nchannels == 1 ? " channel (" : " channels (") + names + ")";
  if (settings.encoding != HeightEncoding::Plain) {
    if (spec.nchannels < 3 || type != OIIO::TypeDesc::UINT8)
      throw Error(settings.path + ": the raster has " + found + " of type " + type.c_str() +
                  ": expected red, green and blue of type uint8 for " + settingName("encoding"));
    image.setChannelRange({0, 0, NAN}); // a byte that equals GDAL's tag is no missing height
    return;
  }
  channel = settings.channel.empty() ? 0 : channelNumber(spec.channelnames, settings.channel);
  if (channel < 0)
    throw Error(settings.path + ": unknown " + settingName("channel") + " '" + settings.channel +
                "': expected one of " + names);
  if (settings.channel.empty() && spec.nchannels > 1)
    throw Error(settings.path + ": the raster has " + found + ": expected one channel, the heights; " +
                settingName("channel") + " selects one of several, " + settingName("encoding") +
                " decodes heights from colors");
  unit = image.unit();
  try {
    scale = heightScale(image.geoTags(), channel);
  } catch (const Error& e) { throw Error(settings.path + ": " + e.what()); }
  image.setChannelRange({channel, 1, NAN});
}

/* Repeated rasters are small and are read completely. */
void Elevation::readRows(int begin, int end) {
  if (settings.repeatX > 1 || settings.repeatY > 1) {
    begin = 0;
    end = sourceHeight;
  }
  if (begin >= firstRow && end <= firstRow + int(rows.size() / size_t(sourceWidth))) return;
  rows.resize(size_t(sourceWidth) * size_t(end - begin));
  firstRow = begin;
  if (settings.encoding == HeightEncoding::Plain) readChannels(begin, end, channel, channel + 1, rows.data());
  else
    for (int y = begin; y < end; y += decodedRows)
      decodeRows(y, std::min(y + decodedRows, end), &rows[size_t(y - begin) * size_t(sourceWidth)]);
  for (float& height : rows) {
    height = unit == 1 ? height : std::round(height * unit);
    if (settings.nodata && height == *settings.nodata) height = NAN;
    if (!scale.isIdentity()) height = float(scale.offset + scale.scale * double(height));
  }
}

void Elevation::readChannels(int begin, int end, int firstChannel, int lastChannel, float* out) {
  if (!image.read_scanlines(picture, 0, begin, end, 0, firstChannel, lastChannel, OIIO::TypeDesc::FLOAT, out))
    throw Error(settings.path + ": cannot read rows of this elevation raster: " + image.geterror());
}

void Elevation::decodeRows(int begin, int end, float* out) {
  const size_t channels = size_t(image.spec().nchannels), count = size_t(sourceWidth) * size_t(end - begin);
  const int alpha = image.spec().alpha_channel;
  std::vector<float> colors(count * channels);
  readChannels(begin, end, 0, int(channels), colors.data());
  for (size_t i = 0; i < count; i++) {
    const float* const color = &colors[i * channels];
    out[i] = alpha >= 0 && color[alpha] == 0 ? NAN : decodeHeight(settings.encoding, color);
  }
}

float Elevation::noiseAt(int x, int y) const {
  float sum = 0, amplitude = settings.noiseHeight, frequency = 1 / longestWave;
  for (int octave = 0; octave < octaves; octave++, amplitude *= 0.5f, frequency *= 2)
    sum += amplitude * gradientNoise({float(x) * frequency, float(y) * frequency, 0.5f}, uint32_t(octave));
  return sum;
}

std::vector<float> Elevation::heights(int x0, int y0, int w, int h, unsigned threads) {
  const bool isRepeated = settings.repeatX > 1 || settings.repeatY > 1;
  readRows(y0, y0 + h);
  std::vector<float> heights(size_t(w) * size_t(h));
  parallelFor(size_t(h), 16, threads, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; row++)
      for (int column = 0; column < w; column++) {
        const int x = x0 + column, y = y0 + int(row);
        const size_t index =
            size_t(mirrored(y, sourceHeight) - firstRow) * size_t(sourceWidth) + size_t(mirrored(x, sourceWidth));
        heights[row * size_t(w) + size_t(column)] =
            rows[index] + (isRepeated && settings.noiseHeight > 0 ? noiseAt(x, y) : 0);
      }
  });
  return heights;
}

GeoTags Elevation::geoTags(int x0, int y0) const {
  GeoTags tags = image.geoTags();
  if ((settings.repeatX > 1 || settings.repeatY > 1) && !samplePlaces(tags)) tags.tiepoints.clear();
  return tagsOfPart(tags, size_t(x0), size_t(y0));
}

} // namespace programs
