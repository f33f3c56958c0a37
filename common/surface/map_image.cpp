// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/map_image.h"
#include "surface/exr_levels.h"
#include "surface/map_rejections.h"
#include "surface/pnm_image.h"

#include <OpenImageIO/half.h>

#include <algorithm>
#include <cfloat>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <system_error>

namespace programs {
namespace {

constexpr const char* firstAttribute = "cbvh:first";
constexpr const char* countAttribute = "cbvh:count";
constexpr const char* neutralAttribute = "cbvh:neutral";
constexpr const char* firstsAttribute = "cbvh:firsts";

/* TIFF's PhotometricInterpretation. */
enum Photometric { WhiteIsZero = 0, BlackIsZero = 1, Rgb = 2 };

/* TIFF's NewSubfileType. */
enum SubfileType { ReducedResolution = 1, Mask = 4 };

/* "No value" is the lowest float, which some programs round. */
constexpr float lowestHeight = -3.4e38f;

bool isMissing(float height) { return std::isnan(height) || (height <= lowestHeight && std::isfinite(height)); }

bool isSampledNatively(OIIO::TypeDesc type) {
  return type == OIIO::TypeDesc::UINT8 || type == OIIO::TypeDesc::UINT16 || type == OIIO::TypeDesc::HALF ||
         type == OIIO::TypeDesc::FLOAT;
}

/* The visible part of the image. Only OpenEXR has true display windows; elsewhere, a window as large as the data but
 * at another position is a place on a page. */
OIIO::ROI displayWindow(const OIIO::ImageSpec& spec, const std::string& format) {
  const OIIO::ROI data = spec.roi(), full = spec.roi_full();
  const bool isOnPage = format != "openexr" && full.width() == data.width() && full.height() == data.height();
  return isOnPage || full.width() < 1 || full.height() < 1 ? data : full;
}

/* Bits of a sample in the file: fewer than its type has if a TIFF file has packed integers. */
int bitsOf(const OIIO::ImageSpec& spec) {
  const int bits = int(8 * spec.format.size());
  return std::clamp(spec.get_int_attribute("oiio:BitsPerSample", bits), 1, bits);
}

/* Sample of the file that OpenImageIO maps to 1. It stretches unsigned integers to the range of their type. */
float unitOf(const OIIO::ImageSpec& spec) {
  if (isUnsigned(spec.format)) return float(std::ldexp(1.0, bitsOf(spec)) - 1);
  switch (spec.format.basetype) {
  case OIIO::TypeDesc::INT8: return std::numeric_limits<int8_t>::max();
  case OIIO::TypeDesc::INT16: return std::numeric_limits<int16_t>::max();
  case OIIO::TypeDesc::INT32: return float(std::numeric_limits<int32_t>::max());
  default: return spec.get_float_attribute(PnmImage::maximumAttribute, 1.0f);
  }
}

template<typename T>
void compare(const void* samples, double value, std::vector<char>& equals) {
  const T* const all = static_cast<const T*>(samples);
  for (size_t i = 0; i < equals.size(); i++) equals[i] = all[i] == T(value);
}

/* Finds samples that equal a value rounded to their type. */
void compareSamples(OIIO::TypeDesc type, const void* samples, double value, std::vector<char>& equals) {
  switch (type.basetype) {
  case OIIO::TypeDesc::UINT8: return compare<uint8_t>(samples, value, equals);
  case OIIO::TypeDesc::INT8: return compare<int8_t>(samples, value, equals);
  case OIIO::TypeDesc::UINT16: return compare<uint16_t>(samples, value, equals);
  case OIIO::TypeDesc::INT16: return compare<int16_t>(samples, value, equals);
  case OIIO::TypeDesc::UINT32: return compare<uint32_t>(samples, value, equals);
  case OIIO::TypeDesc::INT32: return compare<int32_t>(samples, value, equals);
  case OIIO::TypeDesc::HALF: return compare<half>(samples, value, equals);
  case OIIO::TypeDesc::FLOAT: return compare<float>(samples, value, equals);
  case OIIO::TypeDesc::DOUBLE: return compare<double>(samples, value, equals);
  default: return;
  }
}

} // namespace

OIIO::ImageSpec MapImage::configuration(const ChannelRange& range, const std::vector<int>& firstChannels) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1); // keep colors unmultiplied
  config.attribute(firstAttribute, range.first);
  config.attribute(countAttribute, range.count);
  config.attribute(neutralAttribute, range.neutral);
  if (!firstChannels.empty())
    config.attribute(firstsAttribute, OIIO::TypeDesc(OIIO::TypeDesc::INT, int(firstChannels.size())),
                     firstChannels.data());
  return config;
}

bool MapImage::open(const std::string& path, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) {
  close();
  range.first = config.get_int_attribute(firstAttribute, range.first);
  range.count = config.get_int_attribute(countAttribute, range.count);
  range.neutral = config.get_float_attribute(neutralAttribute, range.neutral);
  if (const OIIO::ParamValue* const firsts = config.find_attribute(firstsAttribute))
    firstChannels.assign(static_cast<const int*>(firsts->data()),
                         static_cast<const int*>(firsts->data()) + firsts->type().numelements());
  file = path;
  if (!openSource(config)) return false;
  if (std::string(source->format_name()) == "tiff") pages = readTiffPages(path);
  isRipMapped = hasParts() && source->spec().tile_width && hasRipMaps(path);
  image = 0;
  if (!describe()) return false;
  spec = m_spec;
  return true;
}

bool MapImage::openSource(const OIIO::ImageSpec& config) {
  if (!PnmImage::isPnm(file)) {
    source = OIIO::ImageInput::open(file, &config);
    if (!source) errorfmt("{}", OIIO::geterror());
    return source != nullptr;
  }
  auto pnm = std::make_unique<PnmImage>();
  OIIO::ImageSpec spec;
  if (!pnm->open(file, spec)) {
    errorfmt("{}", pnm->geterror());
    return false;
  }
  source = std::move(pnm);
  return true;
}

bool MapImage::close() {
  source.reset();
  firstChannels.clear();
  pages.clear();
  rejectionText.clear();
  image = -1;
  return true;
}

bool MapImage::seek_subimage(int subimage, int miplevel) {
  const lock_guard lock(*this);
  if (!source || miplevel != 0) return false;
  if (subimage == image) return rejectionText.empty();
  if (!source->seek_subimage(subimage, 0)) {
    source->geterror(); // clears "no more images"
    return false;
  }
  image = subimage;
  return describe();
}

bool MapImage::describe() {
  const OIIO::ImageSpec& from = source->spec();
  const std::string format = source->format_name();
  const int photometric = format == "tiff" ? from.get_int_attribute("tiff:PhotometricInterpretation", -1) : -1;
  copyOrMask = (from.get_int_attribute("tiff:subfiletype", 0) & (ReducedResolution | Mask)) != 0;
  isFloating = from.format.is_floating_point();
  isInverted = photometric == WhiteIsZero && from.format != OIIO::TypeDesc::UINT8;
  rejectionText = rejectionOf(*source, file, isInverted);
  if (!rejectionText.empty()) {
    errorfmt("{}", rejectionText);
    return false;
  }
  window = displayWindow(from, format);
  nodata = nodataOf(from);
  sampleUnit = unitOf(from);
  tile = std::min(from.tile_width, from.tile_height);
  if (size_t(image) < firstChannels.size()) range.first = firstChannels[size_t(image)];
  const bool isOwnFormat = format == "pnm" && from.format != OIIO::TypeDesc::UINT8;
  textureReadable = !isRipMapped && !isOwnFormat && isSampledNatively(from.format) && !isInverted &&
                    window == from.roi() && window.xbegin == 0 && window.ybegin == 0;
  m_spec = OIIO::ImageSpec(window.width(), window.height(), from.nchannels, OIIO::TypeDesc::FLOAT);
  m_spec.channelnames = from.channelnames;
  m_spec.alpha_channel = from.alpha_channel;
  m_spec.attribute("oiio:subimagename", from.get_string_attribute("oiio:subimagename"));
  return true;
}

/* The value of GDAL's tag as OpenImageIO returns it, in the type of the samples. */
std::optional<double> MapImage::nodataOf(const OIIO::ImageSpec& from) const {
  const int photometric = from.get_int_attribute("tiff:PhotometricInterpretation", -1);
  if (size_t(image) >= pages.size() || !from.channelformats.empty() || photometric < WhiteIsZero ||
      photometric > Rgb) // OpenImageIO converts other color spaces
    return {};
  std::string_view text = pages[size_t(image)].tags.nodata;
  text.remove_prefix(std::min(text.find_first_not_of(" +"), text.size()));
  double value = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc() || std::isnan(value))
    return {};    // NaN always means missing
  if (isFloating) // a float cannot hold the lowest double
    return from.format == OIIO::TypeDesc::DOUBLE || std::abs(value) <= FLT_MAX ? value : std::copysign(INFINITY, value);
  const int bits = bitsOf(from);
  const double most = std::ldexp(1.0, isUnsigned(from.format) ? bits : bits - 1) - 1;
  const double least = isUnsigned(from.format) ? 0 : -most - 1;
  if (!(value >= least && value <= most) || value != std::floor(value)) return {}; // no sample can have this value
  if (isUnsigned(from.format))
    value = std::floor(value * (std::ldexp(1.0, int(8 * from.format.size())) - 1) / most); // 1 to 7 and 9 to 15 bits
  return photometric == WhiteIsZero && !isInverted ? 255 - value : value;
}

GeoTags MapImage::geoTags() const {
  return image >= 0 && size_t(image) < pages.size() ? pages[size_t(image)].tags : GeoTags();
}

bool MapImage::read_native_scanlines(int subimage, int miplevel, int yBegin, int yEnd, int, void* data) {
  const lock_guard lock(*this);
  if (!seek_subimage(subimage, miplevel)) return false;
  float* const out = static_cast<float*>(data);
  const size_t channels = size_t(m_spec.nchannels), rowFloats = size_t(m_spec.width) * channels;
  std::fill(out, out + rowFloats * size_t(yEnd - yBegin), range.neutral);
  const OIIO::ROI from = source->spec().roi();
  const int top = std::max(yBegin + window.ybegin, from.ybegin), bottom = std::min(yEnd + window.ybegin, from.yend);
  const int left = std::max(window.xbegin, from.xbegin), right = std::min(window.xend, from.xend);
  if (top >= bottom || left >= right) return true;
  std::vector<float> rows;
  if (!readRows(top, bottom, rows)) return false;
  for (int y = top; y < bottom; y++) {
    const float* const row = &rows[size_t(y - top) * size_t(from.width()) * channels];
    std::copy(row + size_t(left - from.xbegin) * channels, row + size_t(right - from.xbegin) * channels,
              out + rowFloats * size_t(y - window.ybegin - yBegin) + size_t(left - window.xbegin) * channels);
  }
  return true;
}

/* All channels of rows of the source's data window. */
bool MapImage::readRows(int yBegin, int yEnd, std::vector<float>& rows) {
  const OIIO::ImageSpec& from = source->spec();
  const size_t rowSamples = size_t(from.width) * size_t(from.nchannels);
  int begin = yBegin, end = yEnd; // rounded to tiles
  if (from.tile_width) {
    begin = from.y + (yBegin - from.y) / from.tile_height * from.tile_height;
    end = from.y + (yEnd - from.y + from.tile_height - 1) / from.tile_height * from.tile_height;
    end = std::min(end, from.y + from.height);
  }
  const OIIO::TypeDesc type = nodata ? from.format : OIIO::TypeDesc(OIIO::TypeDesc::FLOAT);
  std::vector<char> samples(size_t(end - begin) * rowSamples * type.size());
  const bool isRead =
      from.tile_width ? source->read_tiles(image, 0, from.x, from.x + from.width, begin, end, from.z, from.z + 1, 0,
                                           from.nchannels, type, samples.data())
                      : source->read_scanlines(image, 0, begin, end, from.z, 0, from.nchannels, type, samples.data());
  /* For truncated files, some readers fill in the rest and only leave a message. */
  if (!isRead || source->has_error()) {
    errorfmt("{}", source->geterror());
    return false;
  }
  const char* const first = &samples[size_t(yBegin - begin) * rowSamples * type.size()];
  rows.resize(size_t(yEnd - yBegin) * rowSamples);
  std::vector<char> equalsNodata(nodata ? rows.size() : 0);
  if (nodata) compareSamples(type, first, *nodata, equalsNodata);
  for (size_t i = 0; i < rows.size(); i += rowSamples)
    OIIO::convert_pixel_values(type, first + i * type.size(), OIIO::TypeDesc::FLOAT, &rows[i], int(rowSamples));
  if (isInverted)
    for (size_t i = 0; i < rows.size(); i++)
      if (int(i % size_t(from.nchannels)) != from.alpha_channel) rows[i] = 1.0f - rows[i];
  if (isFloating || nodata) replaceMissing(rows, equalsNodata);
  return true;
}

/* In texels where one channel is missing, replaces all channels. */
void MapImage::replaceMissing(std::vector<float>& rows, const std::vector<char>& equalsNodata) {
  const size_t channels = size_t(m_spec.nchannels), first = std::min(size_t(range.first), channels);
  const size_t last = std::min(first + size_t(range.count), channels);
  for (size_t i = 0; i < rows.size(); i += channels) {
    bool isMissingTexel = false;
    for (size_t c = first; c < last; c++)
      isMissingTexel |= (isFloating && isMissing(rows[i + c])) || (!equalsNodata.empty() && equalsNodata[i + c]);
    if (!isMissingTexel) continue;
    missing++;
    std::fill(rows.begin() + ptrdiff_t(i + first), rows.begin() + ptrdiff_t(i + last), range.neutral);
  }
}

} // namespace programs
