// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/input_bytes.h"
#include "basics/error.h"
#include "basics/progress.h"
#include "basics/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <system_error>

namespace programs {

InputBytes::InputBytes(std::istream& stream, const std::string& name) : stream(stream), path(name) {
  std::streambuf& from = *stream.rdbuf();
  const std::streamoff now = from.pubseekoff(0, std::ios::cur, std::ios::in);
  const std::streamoff last = now < 0 ? now : std::streamoff(from.pubseekoff(0, std::ios::end, std::ios::in));
  if (last >= now && now >= 0 && from.pubseekpos(now, std::ios::in) == now) size = uint64_t(last - now);
  constexpr uint64_t least = 4096, most = 1 << 20;
  buffer.resize(size_t(std::clamp(size, least, most)));
}

uint64_t InputBytes::following() const { return size == ~uint64_t(0) ? size : size - std::min(size, offset()); }

size_t InputBytes::capacityFor(uint64_t count, size_t bytes) const {
  constexpr uint64_t unknown = 1 << 16; // of a pipe; vectors grow
  if (size == ~uint64_t(0)) return size_t(std::min(count, unknown));
  return size_t(std::min(count, following() / std::max<size_t>(bytes, 1)));
}

void InputBytes::fill(size_t count) {
  throwIfCanceled();
  std::memmove(buffer.data(), data(), end - begin);
  consumed += begin;
  end -= begin;
  begin = 0;
  if (count > buffer.size()) buffer.resize(std::max(count, 2 * buffer.size()));
  while (end < count) {
    try {
      const std::streamsize bytes =
          stream.rdbuf()->sgetn(reinterpret_cast<char*>(buffer.data()) + end, std::streamsize(buffer.size() - end));
      if (bytes <= 0) return;
      end += size_t(bytes);
    } catch (const std::ios_base::failure&) { fail("read error"); }
  }
}

bool InputBytes::readLine(std::string_view& line) {
  const auto isEnd = [](uint8_t c) { return c == '\n' || c == '\r'; };
  size_t length = 0;
  for (;;) {
    const size_t buffered = require(length + 1);
    length = size_t(std::find_if(data() + length, data() + buffered, isEnd) - data());
    if (length < buffered) break;
    if (require(length + 1) == length) { // the last line has no end
      if (length == 0) return false;
      break;
    }
  }
  const size_t buffered = require(length + 2);
  const size_t ends = length == buffered                                                              ? 0
                      : data()[length] == '\r' && length + 1 < buffered && data()[length + 1] == '\n' ? 2
                                                                                                      : 1;
  line = std::string_view(reinterpret_cast<const char*>(data()), length);
  skip(length + ends);
  lines++;
  return true;
}

void InputBytes::fail(const std::string& what) const { throw Error(path + ": " + printable(what)); }

void InputBytes::failAtLine(const std::string& what) const {
  throw Error(path + ":" + std::to_string(lines) + ": " + printable(what));
}

std::string quotedWord(std::string_view word) {
  constexpr size_t longest = 32;
  return "'" + printable(std::string(word.substr(0, longest))) + (word.size() > longest ? "..." : "") + "'";
}

bool parseReal(std::string_view word, double& value) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const char* const last = word.data() + word.size();
  const auto [end, code] = std::from_chars(word.data(), last, value);
  if (end != last || word.empty()) return false;
  if (code == std::errc::result_out_of_range) {
    long double wide = 0;
    if (std::from_chars(word.data(), last, wide).ec != std::errc()) // an exponent of thousands
      wide = word.find("e-") == word.npos && word.find("E-") == word.npos ? INFINITY : 0;
    value = std::abs(wide) < 1 ? 0 : wide < 0 ? -INFINITY : INFINITY;
    return true;
  }
  return code == std::errc();
}

bool parseInteger(std::string_view word, int64_t& value) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const char* const last = word.data() + word.size();
  const auto [end, code] = std::from_chars(word.data(), last, value);
  return end == last && !word.empty() && code == std::errc();
}

} // namespace programs
