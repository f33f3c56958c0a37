// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes small TIFF files of layouts that OpenImageIO's writer does not produce: signed integers, white as zero,
 * palettes, bilevel, CMYK, tags of GeoTIFF and GDAL, both byte orders and BigTIFF. Uncompressed. */

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace programs::test {

/* The values of a page's tags, from the TIFF 6.0 specification and GDAL's, and the form of the file. */
struct TiffLayout {
  unsigned width = 0, height = 0;
  unsigned bits = 8;        // per sample; multiples of 8 if isPlanar or tile is set
  unsigned format = 1;      // SampleFormat: 1 unsigned, 2 signed, 3 floating point, 5 and 6 complex
  unsigned photometric = 1; // 0 white is zero, 1 black is zero, 2 RGB, 3 palette, 5 CMYK, 6 YCbCr, 8 CIELab
  unsigned samples = 1;     // per pixel
  bool isPlanar = false;    // one plane per sample
  unsigned tile = 0;        // edge of the tiles, a multiple of 16; 0: one strip, or one per plane
  int extra = -1;           // ExtraSamples of the last sample: 0 unspecified, 1 associated alpha, 2 unassociated alpha
  std::vector<uint16_t> colors;                      // of a palette: all red, all green, all blue values
  std::string nodata;                                // GDAL's tag 42113, left out if empty
  std::string metadata;                              // GDAL's tag 42112
  bool endsTexts = true;                             // texts end with a zero, as the specification requires
  std::vector<double> pixelScale, tiepoints, matrix; // of GeoTIFF
  std::vector<uint16_t> geoKeys;
  unsigned subfile = 0;                        // NewSubfileType: 1 a smaller copy of the page before, 4 a mask
  bool isBigEndian = false, isBigTiff = false; // for writeTiff; TiffWriter has its own
};

class TiffWriter {
public:
  explicit TiffWriter(bool isBigEndian, bool isBigTiff) : isBigEndian(isBigEndian), isBigTiff(isBigTiff) {
    bytes = isBigEndian ? "MM" : "II";
    put(isBigTiff ? 43 : 42, 2);
    if (isBigTiff) {
      put(8, 2);
      put(0, 2);
    }
    link = bytes.size();
    put(0, offsetBytes());
  }

  /* Appends a page. samples: the pixels row by row, all samples of a pixel together, as little-endian numbers of `bits`
   * bits; rows of bilevel images are padded to bytes. Complex samples are only valid in little-endian files. */
  void addPage(const TiffLayout& t, const std::string& samples) {
    std::vector<uint64_t> offsets, sizes;
    for (const std::string& chunk : chunks(t, samples)) {
      offsets.push_back(bytes.size());
      sizes.push_back(chunk.size());
      bytes += chunk;
    }
    bytes.resize((bytes.size() + 7) / 8 * 8);
    entries.clear();
    if (t.subfile) addEntry(254, Long, {t.subfile});                // NewSubfileType
    addEntry(256, Long, {t.width});                                 // ImageWidth
    addEntry(257, Long, {t.height});                                // ImageLength
    addEntry(258, Short, std::vector<uint64_t>(t.samples, t.bits)); // BitsPerSample
    addEntry(259, Short, {1});                                      // Compression: none
    addEntry(262, Short, {t.photometric});                          // PhotometricInterpretation
    if (!t.tile) addEntry(273, Long, offsets);                      // StripOffsets
    addEntry(277, Short, {t.samples});                              // SamplesPerPixel
    if (!t.tile) {
      addEntry(278, Long, {t.height}); // RowsPerStrip
      addEntry(279, Long, sizes);      // StripByteCounts
    }
    addEntry(284, Short, {t.isPlanar ? 2u : 1u});                                    // PlanarConfiguration
    if (!t.colors.empty()) addEntry(320, Short, {t.colors.begin(), t.colors.end()}); // ColorMap
    if (t.tile) {
      addEntry(322, Long, {t.tile}); // TileWidth
      addEntry(323, Long, {t.tile}); // TileLength
      addEntry(324, Long, offsets);  // TileOffsets
      addEntry(325, Long, sizes);    // TileByteCounts
    }
    if (t.extra >= 0) addEntry(338, Short, {unsigned(t.extra)});                          // ExtraSamples
    addEntry(339, Short, std::vector<uint64_t>(t.samples, t.format));                     // SampleFormat
    if (t.photometric == 6) addEntry(530, Short, {1, 1});                                 // YCbCrSubSampling: none
    addNumbers(33550, t.pixelScale);                                                      // ModelPixelScaleTag
    addNumbers(33922, t.tiepoints);                                                       // ModelTiepointTag
    addNumbers(34264, t.matrix);                                                          // ModelTransformationTag
    if (!t.geoKeys.empty()) addEntry(34735, Short, {t.geoKeys.begin(), t.geoKeys.end()}); // GeoKeyDirectoryTag
    addText(42112, t.metadata, t.endsTexts);                                              // GDAL_METADATA
    addText(42113, t.nodata, t.endsTexts);                                                // GDAL_NODATA
    writeDirectory();
  }

  void save(const std::string& path) const { std::ofstream(path, std::ios::binary) << bytes; }

private:
  enum Type { Ascii = 2, Short = 3, Long = 4, Double = 12 };

  struct Entry {
    unsigned tag;
    Type type;
    std::vector<uint64_t> values;
  };

  unsigned offsetBytes() const { return isBigTiff ? 8 : 4; }

  static std::string number(uint64_t value, unsigned size, bool isBigEndian) {
    std::string text;
    for (unsigned i = 0; i < size; i++) text += char(value >> 8 * (isBigEndian ? size - 1 - i : i));
    return text;
  }

  void put(uint64_t value, unsigned size) { bytes += number(value, size, isBigEndian); }

  void addEntry(unsigned tag, Type type, const std::vector<uint64_t>& values) {
    entries.push_back({tag, type, values});
  }

  void addNumbers(unsigned tag, const std::vector<double>& numbers) {
    std::vector<uint64_t> bits(numbers.size());
    std::memcpy(bits.data(), numbers.data(), numbers.size() * sizeof(double));
    if (!bits.empty()) addEntry(tag, Double, bits);
  }

  void addText(unsigned tag, const std::string& text, bool isEnded) {
    std::vector<uint64_t> letters(text.begin(), text.end());
    if (isEnded) letters.push_back(0);
    if (!text.empty()) addEntry(tag, Ascii, letters);
  }

  static unsigned typeBytes(Type type) { return type == Ascii ? 1 : type == Short ? 2 : type == Double ? 8 : 4; }

  std::string valuesOf(const Entry& e) const {
    std::string text;
    for (uint64_t value : e.values) text += number(value, typeBytes(e.type), isBigEndian);
    return text;
  }

  void writeDirectory() {
    std::vector<uint64_t> offsets(entries.size());
    for (size_t i = 0; i < entries.size(); i++) {
      const std::string values = valuesOf(entries[i]);
      offsets[i] = bytes.size();
      if (values.size() > offsetBytes()) bytes += values + std::string(values.size() % 2, '\0');
    }
    const std::string start = number(bytes.size(), offsetBytes(), isBigEndian);
    std::copy(start.begin(), start.end(), bytes.begin() + ptrdiff_t(link));
    put(entries.size(), isBigTiff ? 8 : 2);
    for (size_t i = 0; i < entries.size(); i++) {
      put(entries[i].tag, 2);
      put(entries[i].type, 2);
      put(entries[i].values.size(), offsetBytes());
      std::string values = valuesOf(entries[i]);
      if (values.size() > offsetBytes()) values = number(offsets[i], offsetBytes(), isBigEndian);
      values.resize(offsetBytes());
      bytes += values;
    }
    link = bytes.size();
    put(0, offsetBytes());
  }

  /* Returns the strips or tiles, in the byte order of the file. */
  std::vector<std::string> chunks(const TiffLayout& t, std::string samples) const {
    const unsigned size = t.bits / 8;
    if (isBigEndian && size > 1)
      for (size_t i = 0; i + size <= samples.size(); i += size)
        std::reverse(samples.begin() + ptrdiff_t(i), samples.begin() + ptrdiff_t(i + size));
    if (!t.isPlanar && !t.tile) return {samples};
    std::vector<std::string> all;
    const unsigned step = t.isPlanar ? 1 : t.samples, w = t.tile ? t.tile : t.width, h = t.tile ? t.tile : t.height;
    for (unsigned first = 0; first < t.samples; first += step)
      for (unsigned y0 = 0; y0 < t.height; y0 += h)
        for (unsigned x0 = 0; x0 < t.width; x0 += w) {
          std::string chunk;
          for (unsigned y = y0; y < y0 + h; y++)
            for (unsigned x = x0; x < x0 + w; x++) {
              const size_t pixel = size_t(std::min(y, t.height - 1)) * t.width + std::min(x, t.width - 1);
              chunk += samples.substr((pixel * t.samples + first) * size, size_t(step) * size);
            }
          all.push_back(chunk);
        }
    return all;
  }

  bool isBigEndian, isBigTiff;
  std::string bytes;
  size_t link = 0; // position in `bytes` where the offset of the next directory is stored
  std::vector<Entry> entries;
};

/* Writes a TIFF of one page. */
inline void writeTiff(const std::string& path, const TiffLayout& layout, const std::string& samples) {
  TiffWriter writer(layout.isBigEndian, layout.isBigTiff);
  writer.addPage(layout, samples);
  writer.save(path);
}

/* The bytes of samples, as TiffWriter::addPage expects them on a little-endian machine. */
template<typename T>
std::string bytesOf(const std::vector<T>& samples) {
  return std::string(reinterpret_cast<const char*>(samples.data()), samples.size() * sizeof(T));
}

} // namespace programs::test
