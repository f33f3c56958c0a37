// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The values of PLY elements, one after the other, in text and binary. Both classes have the same members. */

#include "meshes/input_bytes.h"
#include "meshes/ply_header.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace programs {

/* One element per line, as in the format's definition. Blank lines are skipped. */
class PlyText {
public:
  explicit PlyText(InputBytes& input) : input(input) {}

  void begin(const PlyElement& of, uint64_t number) {
    element = &of;
    index = number;
    std::string_view words;
    do {
      if (!input.readLine(line)) failAtEnd();
      words = line;
    } while (nextWord(words).empty());
  }

  double real(PlyType) {
    double value;
    const std::string_view word = next();
    if (!parseReal(word, value)) fail(quotedWord(word) + ": expected a number");
    return value;
  }

  int64_t integer(PlyType) {
    int64_t value;
    const std::string_view word = next();
    if (!parseInteger(word, value)) fail(quotedWord(word) + ": expected an integer");
    return value;
  }

  void skip(PlyType, int64_t count) {
    for (; count > 0; count--) next();
  }

  void end() {
    const std::string_view word = nextWord(line);
    if (!word.empty()) fail(quotedWord(word) + " follows the last value: expected the end of the line");
  }

  void requireEnd() {
    while (input.readLine(line))
      if (const std::string_view word = nextWord(line); !word.empty() && word != "\x1a") // end of old text files
        input.failAtLine(quotedWord(word) +
                         " follows the last element: expected the end of the file, or another count in "
                         "the header");
  }

  [[noreturn]] void fail(const std::string& what) const {
    input.failAtLine(element->name + " " + std::to_string(index) + ": " + what);
  }

private:
  std::string_view next() {
    const std::string_view word = nextWord(line);
    if (word.empty()) fail("the line has too few values: expected all properties of the header in one line");
    return word;
  }

  [[noreturn]] void failAtEnd() const {
    input.fail("the file ends before " + element->name + " " + std::to_string(index) + ": expected " +
               std::to_string(element->count) + " of them");
  }

  InputBytes& input;
  std::string_view line; // the values that follow
  const PlyElement* element = nullptr;
  uint64_t index = 0;
};

class PlyBinary {
public:
  PlyBinary(InputBytes& input, bool isBigEndian) : input(input), isBigEndian(isBigEndian) {}

  void begin(const PlyElement& of, uint64_t number) {
    element = &of;
    index = number;
  }

  double real(PlyType type) {
    switch (type) {
    case PlyType::Float32: return double(value<float>());
    case PlyType::Float64: return value<double>();
    default: return double(integer(type));
    }
  }

  /* Requires a type of integers. */
  int64_t integer(PlyType type) {
    switch (type) {
    case PlyType::Int8: return value<int8_t>();
    case PlyType::UInt8: return value<uint8_t>();
    case PlyType::Int16: return value<int16_t>();
    case PlyType::UInt16: return value<uint16_t>();
    case PlyType::Int32: return value<int32_t>();
    default: return value<uint32_t>();
    }
  }

  void skip(PlyType type, int64_t count) {
    for (uint64_t left = uint64_t(count) * sizeOf(type); left > 0;) {
      const size_t bytes = size_t(std::min<uint64_t>(left, 65536));
      if (input.require(bytes) < bytes) failAtEnd();
      input.skip(bytes);
      left -= bytes;
    }
  }

  void end() {}

  void requireEnd() {
    while (input.require(1)) { // some programs append a line end
      const uint8_t byte = *input.data();
      if (byte != '\n' && byte != '\r' && byte != ' ' && byte != 0)
        input.fail("data follows the last element, at byte " + std::to_string(input.offset()) +
                   ": expected the end of the file, or another count in the header");
      input.skip(1);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    input.fail(element->name + " " + std::to_string(index) + ": " + what);
  }

private:
  template<typename T>
  T value() {
    if (input.require(sizeof(T)) < sizeof(T)) failAtEnd();
    uint8_t bytes[sizeof(T)];
    std::memcpy(bytes, input.data(), sizeof(T));
    input.skip(sizeof(T));
    if (isBigEndian) std::reverse(bytes, bytes + sizeof(T));
    T result;
    std::memcpy(&result, bytes, sizeof(T));
    return result;
  }

  [[noreturn]] void failAtEnd() const {
    input.fail("the file ends within " + element->name + " " + std::to_string(index) + ": expected " +
               std::to_string(element->count) + " of them");
  }

  InputBytes& input;
  bool isBigEndian;
  const PlyElement* element = nullptr;
  uint64_t index = 0;
};

} // namespace programs
