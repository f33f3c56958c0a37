// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/pnm_image.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

namespace programs {
namespace {

constexpr uint64_t maxEdge = 1u << 24, maxSample = 65535;

bool isBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

} // namespace

bool PnmImage::isPnm(const std::string& path) {
  char start[3] = {};
  std::ifstream(path, std::ios::binary).read(start, 3);
  return start[0] == 'P' && start[1] && std::strchr("123456fF", start[1]) && (isBlank(start[2]) || start[2] == '#');
}

bool PnmImage::fail(const std::string& reason) {
  errorfmt("{}", reason);
  return false;
}

bool PnmImage::open(const std::string& path, OIIO::ImageSpec& spec) {
  close();
  std::ifstream stream(path, std::ios::binary);
  file.assign(std::istreambuf_iterator<char>(stream), {});
  rest = file;
  if (!readHeader()) return false;
  spec = m_spec;
  return true;
}

bool PnmImage::close() {
  file.clear();
  decoded.clear();
  rest = {};
  return true;
}

void PnmImage::skipBlanks() {
  while (!rest.empty() && (isBlank(rest[0]) || rest[0] == '#'))
    rest.remove_prefix(rest[0] == '#' ? std::min(rest.find('\n'), rest.size()) : 1);
}

bool PnmImage::readNumber(uint64_t& value) {
  skipBlanks();
  const auto number = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  rest.remove_prefix(size_t(number.ptr - rest.data()));
  return number.ec == std::errc();
}

bool PnmImage::readScale() {
  skipBlanks();
  const auto number = std::from_chars(rest.data(), rest.data() + rest.size(), scale);
  rest.remove_prefix(size_t(number.ptr - rest.data()));
  isLittleEndian = scale < 0;
  scale = std::abs(scale);
  return number.ec == std::errc() && scale > 0 && std::isfinite(scale);
}

bool PnmImage::readHeader() {
  const char type = rest.size() > 1 ? rest[1] : '\0';
  rest.remove_prefix(std::min<size_t>(2, rest.size()));
  uint64_t width = 0, height = 0, greatest = 1;
  if (!readNumber(width) || !readNumber(height) || width < 1 || height < 1 || width > maxEdge || height > maxEdge)
    return fail("its header has no valid width and height: expected two numbers from 1 to " + std::to_string(maxEdge));
  const bool isFloat = type == 'f' || type == 'F', isBits = type == '1' || type == '4';
  if (isFloat && !readScale()) return fail("its header has no valid scale: expected a number other than 0");
  if (!isFloat && !isBits && (!readNumber(greatest) || greatest < 1 || greatest > maxSample))
    return fail("its header has no valid maximum: expected a number from 1 to " + std::to_string(maxSample));
  most = unsigned(greatest);
  kind = isFloat ? Kind::Floats : type == '4' ? Kind::Bits : Kind::Integers;
  const int channels = type == '3' || type == '6' || type == 'F' ? 3 : 1;
  const bool areBytes = type != '1' && (kind == Kind::Bits || (!isFloat && most == 255));
  m_spec = OIIO::ImageSpec(int(width), int(height), channels, areBytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
  if (kind == Kind::Integers) m_spec.attribute(maximumAttribute, float(most));
  const size_t samples = size_t(width) * size_t(channels);
  rowBytes = kind == Kind::Bits ? (samples + 7) / 8 : samples * (isFloat ? 4 : most > 255 ? 2 : 1);
  if (type >= '1' && type <= '3') return readText(isBits);
  if (rest.empty() || !isBlank(rest[0])) return fail("its header does not end with a blank");
  rest.remove_prefix(1);
  if (rest.size() / rowBytes < height)
    return fail("the file is truncated: expected " + std::to_string(rowBytes * height) +
                " bytes after the header, found " + std::to_string(rest.size()));
  return true;
}

/* Digits of bitmaps need no blanks between them; 1 is black. */
bool PnmImage::readText(bool isBits) {
  const size_t samples = size_t(m_spec.width) * size_t(m_spec.height) * size_t(m_spec.nchannels);
  for (size_t i = 0; i < samples; i++) {
    uint64_t value = 0;
    bool isRead;
    if (isBits) {
      skipBlanks();
      isRead = !rest.empty() && (rest[0] == '0' || rest[0] == '1');
      value = isRead && rest[0] == '0';
      rest.remove_prefix(isRead);
    } else isRead = readNumber(value) && value <= maxSample;
    if (!isRead)
      return fail("sample " + std::to_string(i) + " of " + std::to_string(samples) + " is missing or no valid number");
    if (most > 255) decoded += char(value >> 8);
    else if (value > 255)
      return fail("sample " + std::to_string(i) + " is " + std::to_string(value) + ": expected at most " +
                  std::to_string(most));
    decoded += char(value);
  }
  rest = decoded;
  return true;
}

bool PnmImage::readInteger(const unsigned char* row, size_t i, int y, unsigned& value) {
  value = most > 255 ? row[2 * i] << 8u | row[2 * i + 1] : row[i];
  return value <= most ||
         fail("the sample at texel " + std::to_string(i / size_t(m_spec.nchannels)) + "," + std::to_string(y) + " is " +
              std::to_string(value) + ": expected at most the file's maximum, " + std::to_string(most));
}

bool PnmImage::read_native_scanline(int subimage, int miplevel, int y, int z, void* data) {
  if (subimage != 0 || miplevel != 0 || z != 0 || y < 0 || y >= m_spec.height) return false;
  const bool isFloat = kind == Kind::Floats; // rows from the bottom to the top
  const char* const bytes = rest.data() + rowBytes * size_t(isFloat ? m_spec.height - 1 - y : y);
  const auto* const row = reinterpret_cast<const unsigned char*>(bytes);
  for (size_t i = 0; i < size_t(m_spec.width) * size_t(m_spec.nchannels); i++) {
    unsigned value = 0;
    if (kind == Kind::Bits) value = row[i / 8] >> (7 - i % 8) & 1 ? 0 : 255;
    else if (isFloat)
      for (unsigned byte = 0; byte < 4; byte++)
        value |= unsigned(row[4 * i + byte]) << 8 * (isLittleEndian ? byte : 3 - byte);
    else if (!readInteger(row, i, y, value)) return false;
    if (m_spec.format == OIIO::TypeDesc::UINT8) {
      static_cast<unsigned char*>(data)[i] = static_cast<unsigned char>(value);
      continue;
    }
    float sample = float(value) / float(most);
    if (isFloat) {
      std::memcpy(&sample, &value, sizeof sample);
      sample *= scale;
    }
    static_cast<float*>(data)[i] = sample;
  }
  return true;
}

} // namespace programs
