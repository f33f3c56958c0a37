// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/geo_tiff.h"
#include "basics/error.h"
#include "basics/file_output.h"

#include <tiffio.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string_view>
#include <system_error>
#include <utility>

namespace programs {
namespace {

enum GeoTag : uint32_t {
  PixelScale = 33550,
  Tiepoints = 33922,
  Matrix = 34264,
  Keys = 34735,
  KeyNumbers = 34736,
  KeyTexts = 34737,
  GdalMetadata = 42112,
  GdalNodata = 42113
};

/* --- libtiff -------------------------------------------------------------------- */

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, CloseTiff>;

/* Keeps the first error of a file, and prints no message. */
class TiffOptions {
public:
  explicit TiffOptions(std::string* error) : options(TIFFOpenOptionsAlloc()) {
    TIFFOpenOptionsSetErrorHandlerExtR(options, keepError, error);
    TIFFOpenOptionsSetWarningHandlerExtR(options, ignore, nullptr);
  }
  ~TiffOptions() { TIFFOpenOptionsFree(options); }
  TiffOptions(const TiffOptions&) = delete;
  TiffOptions& operator=(const TiffOptions&) = delete;

  TIFFOpenOptions* get() const { return options; }

private:
  static int keepError(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    std::string& error = *static_cast<std::string*>(user);
    char text[512];
    std::vsnprintf(text, sizeof(text), format, arguments);
    if (error.empty()) error = text;
    return 1;
  }
  static int ignore(TIFF*, void*, const char*, const char*, va_list) { return 1; }

  TIFFOpenOptions* const options;
};

/* GDAL and libgeotiff register the same fields. Texts of unregistered fields would lose their last character where a
 * file ends them without a zero. */
const TIFFFieldInfo geoFields[] = {
    {PixelScale, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoPixelScale")},
    {Tiepoints, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoTiePoints")},
    {Matrix, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoTransformationMatrix")},
    {Keys, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoKeyDirectory")},
    {KeyNumbers, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoDoubleParams")},
    {KeyTexts, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GeoASCIIParams")},
    {GdalMetadata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GDALMetadata")},
    {GdalNodata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GDALNoDataValue")}};

TIFFExtendProc otherExtender = nullptr; // of another library of the process, such as GDAL

/* libtiff forgets registered fields when it reads a directory, unless a function for all files registers them. */
void registerFields() {
  static std::once_flag isRegistered;
  std::call_once(isRegistered, [] {
    otherExtender = TIFFSetTagExtender([](TIFF* tiff) {
      TIFFMergeFieldInfo(tiff, geoFields, uint32_t(std::size(geoFields)));
      if (otherExtender) otherExtender(tiff);
    });
  });
}

/* False if another library of the process registered a tag in another form: TIFFGetField would expect other arguments.
 */
bool isRegistered(TIFF* tiff, uint32_t tag, TIFFDataType type) {
  const TIFFField* const field = TIFFFindField(tiff, tag, TIFF_ANY);
  return field && TIFFFieldDataType(field) == type && TIFFFieldReadCount(field) == TIFF_VARIABLE &&
         bool(TIFFFieldPassCount(field)) == (type != TIFF_ASCII);
}

template<typename T>
std::vector<T> numbersOf(TIFF* tiff, uint32_t tag, TIFFDataType type) {
  uint16_t count = 0;
  const T* values = nullptr;
  if (!isRegistered(tiff, tag, type) || !TIFFGetField(tiff, tag, &count, &values)) return {};
  return {values, values + count};
}

std::string textOf(TIFF* tiff, uint32_t tag) {
  const char* text = nullptr;
  return isRegistered(tiff, tag, TIFF_ASCII) && TIFFGetField(tiff, tag, &text) && text ? text : "";
}

TiffPage readPage(TIFF* tiff) {
  TiffPage page;
  uint32_t subfile = 0;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &page.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &page.height);
  TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &subfile);
  page.isCopyOrMask = (subfile & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
  page.tags.pixelScale = numbersOf<double>(tiff, PixelScale, TIFF_DOUBLE);
  page.tags.tiepoints = numbersOf<double>(tiff, Tiepoints, TIFF_DOUBLE);
  page.tags.matrix = numbersOf<double>(tiff, Matrix, TIFF_DOUBLE);
  page.tags.keys = numbersOf<uint16_t>(tiff, Keys, TIFF_SHORT);
  page.tags.keyNumbers = numbersOf<double>(tiff, KeyNumbers, TIFF_DOUBLE);
  page.tags.keyTexts = textOf(tiff, KeyTexts);
  page.tags.metadata = textOf(tiff, GdalMetadata);
  page.tags.nodata = textOf(tiff, GdalNodata);
  return page;
}

/* --- transformations ------------------------------------------------------------ */

bool hasPixelScale(const GeoTags& t) {
  return t.pixelScale.size() >= 2 && t.pixelScale[0] != 0 && t.pixelScale[1] != 0 && t.tiepoints.size() >= 6;
}

bool hasMatrix(const GeoTags& t) { return t.matrix.size() == 16; }

/* True if a key has a value. */
bool hasKey(const GeoTags& t, uint16_t key, uint16_t value) {
  for (size_t i = 4; i + 4 <= t.keys.size(); i += 4) // four numbers per key, after a header of four
    if (t.keys[i] == key) return t.keys[i + 1] == 0 && t.keys[i + 3] == value;
  return false;
}

/* True if coordinates are those of the centers of pixels, and not of their upper left corners. */
bool isPixelPoint(const GeoTags& t) { return hasKey(t, 1025, 2); }

SamplePlaces movedBy(SamplePlaces p, double columns, double rows) {
  p.x0 += columns * p.xOfColumn + rows * p.xOfRow;
  p.y0 += columns * p.yOfColumn + rows * p.yOfRow;
  return p;
}

/* --- GDAL's metadata --------------------------------------------------------------- */

/* Value of an attribute of an element's start, such as `<Item name="SCALE" sample="0" role="scale"`. */
std::string_view attributeOf(std::string_view start, const std::string& name) {
  const size_t at = start.find(" " + name + "=");
  if (at == std::string_view::npos || at + name.size() + 3 > start.size()) return {};
  const char quote = start[at + name.size() + 2];
  const std::string_view rest = start.substr(at + name.size() + 3);
  return rest.substr(0, rest.find(quote));
}

double numberOf(std::string_view text, const std::string& role) {
  const std::string_view blanks = " \t\r\n";
  std::string_view number = text;
  number.remove_prefix(std::min(number.find_first_not_of(" \t\r\n+"), number.size()));
  number = number.substr(0, number.find_last_not_of(blanks) + 1);
  double value = 0;
  const auto parsed = std::from_chars(number.data(), number.data() + number.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != number.data() + number.size() || !std::isfinite(value))
    throw Error("GDAL's metadata contains the " + role + " '" + std::string(text) + "': expected a finite number");
  return value;
}

/* --- writing -------------------------------------------------------------------- */

/* Receives what libtiff writes. */
class TiffOutput {
public:
  explicit TiffOutput(const std::string& path) : pending(path) {}

  TiffHandle open(const std::string& name, const char* mode, const TiffOptions& options) {
    return TiffHandle(
        TIFFClientOpenExt(name.c_str(), mode, this, read, write, seek, close, size, map, unmap, options.get()));
  }

  PendingFile pending;

private:
  static TiffOutput& of(thandle_t handle) { return *static_cast<TiffOutput*>(handle); }
  static tmsize_t read(thandle_t, void*, tmsize_t) { return 0; } // libtiff does not read what it has written
  static tmsize_t write(thandle_t handle, void* data, tmsize_t bytes) {
    TiffOutput& out = of(handle);
    if (!out.pending.write(data, size_t(bytes), out.position)) return 0;
    out.position += uint64_t(bytes);
    out.end = std::max(out.end, out.position);
    return bytes;
  }
  static toff_t seek(thandle_t handle, toff_t offset, int from) {
    TiffOutput& out = of(handle);
    out.position = offset + (from == SEEK_END ? out.end : from == SEEK_CUR ? out.position : 0);
    return out.position;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t handle) { return of(handle).end; }
  static int map(thandle_t, void**, toff_t*) { return 0; }
  static void unmap(thandle_t, void*, toff_t) {}

  uint64_t position = 0, end = 0;
};

template<typename T>
bool setNumbers(TIFF* tiff, uint32_t tag, const std::vector<T>& values) {
  return values.empty() || TIFFSetField(tiff, tag, int(values.size()), values.data());
}

bool setText(TIFF* tiff, uint32_t tag, const std::string& text) {
  return text.empty() || TIFFSetField(tiff, tag, text.c_str());
}

bool setTags(TIFF* tiff, const RasterSamples& samples, const GeoTags& tags) {
  const int format = samples.kind == SampleKind::Floating ? SAMPLEFORMAT_IEEEFP
                     : samples.kind == SampleKind::Signed ? SAMPLEFORMAT_INT
                                                          : SAMPLEFORMAT_UINT;
  const std::vector<uint16_t> extra(samples.channels - 1, EXTRASAMPLE_UNSPECIFIED);
  return TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, uint32_t(samples.width)) &&
         TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, uint32_t(samples.height)) &&
         TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, int(samples.channels)) &&
         TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, int(samples.bits)) &&
         TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format) &&
         TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK) &&
         (extra.empty() || TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, int(extra.size()), extra.data())) &&
         TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) &&
         TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE) &&
         TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0)) &&
         setNumbers(tiff, PixelScale, tags.pixelScale) && setNumbers(tiff, Tiepoints, tags.tiepoints) &&
         setNumbers(tiff, Matrix, tags.matrix) && setNumbers(tiff, Keys, tags.keys) &&
         setNumbers(tiff, KeyNumbers, tags.keyNumbers) && setText(tiff, KeyTexts, tags.keyTexts) &&
         setText(tiff, GdalNodata, samples.kind == SampleKind::Floating ? "nan" : "");
}

bool writeRows(TIFF* tiff, const RasterSamples& samples) {
  const size_t rowBytes = samples.width * samples.channels * (samples.bits / 8);
  std::vector<char> row(rowBytes); // libtiff's encoders may modify rows
  for (size_t y = 0; y < samples.height; y++) {
    const char* const first = static_cast<const char*>(samples.data) + y * rowBytes;
    std::copy(first, first + rowBytes, row.begin());
    if (TIFFWriteScanline(tiff, row.data(), uint32_t(y), 0) < 0) return false;
  }
  return TIFFWriteDirectory(tiff) != 0;
}

} // namespace

std::vector<TiffPage> readTiffPages(const std::string& path) {
  std::vector<TiffPage> pages;
  std::string ignored;
  const TiffOptions options(&ignored);
  registerFields();
  const TiffHandle tiff(TIFFOpenExt(path.c_str(), "rm", options.get())); // m: not mapped, as the file may be truncated
  if (!tiff) return pages;
  do pages.push_back(readPage(tiff.get()));
  while (TIFFReadDirectory(tiff.get()));
  return pages;
}

std::optional<TiffPage> firstImage(const std::string& path) {
  for (TiffPage& page : readTiffPages(path))
    if (!page.isCopyOrMask) return std::move(page);
  return {};
}

std::optional<SamplePlaces> samplePlaces(const GeoTags& t) {
  SamplePlaces p;
  if (hasPixelScale(t)) {
    p.xOfColumn = t.pixelScale[0];
    p.yOfRow = -std::abs(t.pixelScale[1]);
    p.x0 = t.tiepoints[3] - t.tiepoints[0] * p.xOfColumn;
    p.y0 = t.tiepoints[4] - t.tiepoints[1] * p.yOfRow;
  } else if (hasMatrix(t)) {
    p = {t.matrix[3], t.matrix[0], t.matrix[1], t.matrix[7], t.matrix[4], t.matrix[5]};
  } else return {};
  if (!isPixelPoint(t)) p = movedBy(p, 0.5, 0.5);
  const double area = p.xOfColumn * p.yOfRow - p.xOfRow * p.yOfColumn;
  if (!std::isfinite(area) || area == 0 || !std::isfinite(p.x0) || !std::isfinite(p.y0)) return {};
  return p;
}

void setSamplePlaces(GeoTags& tags, const SamplePlaces& places) {
  const SamplePlaces p = isPixelPoint(tags) ? places : movedBy(places, -0.5, -0.5);
  tags.pixelScale = tags.tiepoints = tags.matrix = {};
  if (!p.isRotated() && p.xOfColumn > 0 && p.yOfRow < 0) {
    tags.pixelScale = {p.xOfColumn, -p.yOfRow, 0};
    tags.tiepoints = {0, 0, 0, p.x0, p.y0, 0};
  } else tags.matrix = {p.xOfColumn, p.xOfRow, 0, p.x0, p.yOfColumn, p.yOfRow, 0, p.y0, 0, 0, 0, 0, 0, 0, 0, 1};
}

std::optional<double> projectedCell(const GeoTags& tags) {
  const std::optional<SamplePlaces> p = samplePlaces(tags);
  if (!p || !hasKey(tags, 1024, 1)) return {};
  const double width = std::hypot(p->xOfColumn, p->yOfColumn), height = std::hypot(p->xOfRow, p->yOfRow);
  if (std::abs(width - height) > 1e-6 * width) return {};
  return width;
}

GeoTags tagsOfPart(GeoTags t, size_t column, size_t row) {
  const double columns = double(column), rows = double(row);
  if (hasMatrix(t))
    for (size_t i = 0; i < 12; i += 4) t.matrix[i + 3] += columns * t.matrix[i] + rows * t.matrix[i + 1];
  for (size_t i = 0; i + 6 <= t.tiepoints.size(); i += 6) {
    if (hasPixelScale(t)) {
      t.tiepoints[i + 3] += columns * t.pixelScale[0];
      t.tiepoints[i + 4] -= rows * std::abs(t.pixelScale[1]);
    } else { // control points
      t.tiepoints[i] -= columns;
      t.tiepoints[i + 1] -= rows;
    }
  }
  return t;
}

HeightScale heightScale(const GeoTags& tags, int channel) {
  HeightScale result;
  const std::string_view xml = tags.metadata;
  const std::string sample = std::to_string(channel);
  for (size_t at = xml.find("<Item"); at != std::string_view::npos; at = xml.find("<Item", at + 1)) {
    const size_t end = xml.find('>', at);
    if (end == std::string_view::npos) break;
    const std::string_view start = xml.substr(at, end - at), role = attributeOf(start, "role");
    if (attributeOf(start, "sample") != sample || (role != "scale" && role != "offset")) continue;
    const double value = numberOf(xml.substr(end + 1, xml.find('<', end) - end - 1), std::string(role));
    (role == "scale" ? result.scale : result.offset) = value;
  }
  return result;
}

void writeGeoTiff(const std::string& path, const RasterSamples& samples, const GeoTags& tags) {
  constexpr size_t mostValues = 65535; // of a tag, as GDAL's fields count them
  if (std::max({tags.pixelScale.size(), tags.tiepoints.size(), tags.matrix.size(), tags.keys.size(),
                tags.keyNumbers.size()}) > mostValues)
    throw Error(path + ": cannot be written: the georeference has a tag of more than 65535 values");
  const double bytes = double(samples.width) * double(samples.height) * double(samples.channels * samples.bits / 8);
  TiffOutput output(path);
  std::string error;
  const TiffOptions options(&error);
  registerFields();
  TiffHandle tiff = output.open(path, bytes > 4e9 ? "w8" : "w", options);
  if (!tiff || !setTags(tiff.get(), samples, tags) || !writeRows(tiff.get(), samples))
    throw Error(path + ": cannot be written: " + (output.pending.error().empty() ? error : output.pending.error()));
  tiff.reset();
  output.pending.commit();
}

} // namespace programs
