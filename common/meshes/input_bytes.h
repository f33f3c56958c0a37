// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Buffered bytes and lines of a file or pipe, for readers of meshes. */

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

namespace programs {

class InputBytes {
public:
  /* Messages use `name` as the path. */
  InputBytes(std::istream& stream, const std::string& name);

  const std::string& name() const { return path; }

  /* Number of bytes before the next one. */
  uint64_t offset() const { return consumed + begin; }

  /* Number of bytes that follow; the largest number if that is not known, as for a pipe. */
  uint64_t following() const;

  /* Capacity to reserve for `count` elements of at least `bytes` each: at most as many as can follow. Headers of
   * damaged files declare any number. */
  size_t capacityFor(uint64_t count, size_t bytes) const;

  /* Buffers `count` bytes if so many follow, and returns how many of the next bytes are buffered. Invalidates data().
   * Throws Error and Canceled. */
  size_t require(size_t count) {
    if (end - begin < count) fill(count);
    return end - begin;
  }

  /* The buffered bytes. */
  const uint8_t* data() const { return buffer.data() + begin; }

  /* Requires buffered bytes. */
  void skip(size_t count) { begin += count; }

  bool atEnd() { return require(1) == 0; }

  /* Reads a line that ends in LF, CR LF or CR. Returns false at the end of the file. The line is valid until the next
   * call. */
  bool readLine(std::string_view& line);

  /* For lines that are read as bytes. */
  void countLine() { lines++; }

  /* Number of the last line that was read, from 1. */
  size_t lineNumber() const { return lines; }

  /* Places of errors: "mesh.ply: " and "mesh.ply:12: ". */
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void failAtLine(const std::string& what) const;

private:
  void fill(size_t count);

  std::istream& stream;
  std::string path;
  std::vector<uint8_t> buffer;
  size_t begin = 0, end = 0;    // of the buffered bytes
  uint64_t consumed = 0;        // bytes before the buffer
  uint64_t size = ~uint64_t(0); // of the file
  size_t lines = 0;
};

/* Removes the next word from a line. Returns "" if there is none. */
inline std::string_view nextWord(std::string_view& line) {
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\f' || c == '\v'; };
  size_t first = 0;
  while (first < line.size() && isBlank(line[first])) first++;
  size_t last = first;
  while (last < line.size() && !isBlank(line[last])) last++;
  const std::string_view word = line.substr(first, last - first);
  line.remove_prefix(last);
  return word;
}

/* Up to 32 characters for a message, within quotes. */
std::string quotedWord(std::string_view word);

/* Return false if the word is no number, or no integer of 64 bits. Reals too small for 64 bits become 0, and those too
 * large infinite. */
bool parseReal(std::string_view word, double& value);
bool parseInteger(std::string_view word, int64_t& value);

} // namespace programs
