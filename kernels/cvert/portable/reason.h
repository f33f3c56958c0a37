// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reasons for rejecting input. Functions that check blocks or records return a Reason, and neither allocate nor throw.
 * Functions on files throw an Error. */

#include <cstdint>
#include <stdexcept>
#include <string>

namespace cvert {
enum class ErrorCode : uint32_t {
  NONE,
  DAMAGED,     //!< the bytes contradict each other or the format
  UNSUPPORTED, //!< version or feature that this library cannot read
  INVALID_ARGUMENT,
  INVALID_OPERATION //!< wrong state, failed write, or geometry that cannot be saved
};

/*! Why bytes are rejected. Converts to true if there is a reason, to false if the bytes are valid. */
class Reason {
public:
  Reason() : code(ErrorCode::NONE), text(""), values{0, 0} {}

  /*! text: static string, not copied. message() replaces the first two % by the values. */
  Reason(ErrorCode code, const char* text, uint64_t first = 0, uint64_t second = 0)
    : code(code),
      text(text),
      values{first, second} {}

  static Reason damaged(const char* text, uint64_t first = 0, uint64_t second = 0) {
    return Reason(ErrorCode::DAMAGED, text, first, second);
  }
  static Reason unsupported(const char* text, uint64_t first = 0, uint64_t second = 0) {
    return Reason(ErrorCode::UNSUPPORTED, text, first, second);
  }

  explicit operator bool() const { return code != ErrorCode::NONE; }

  /*! Empty without a reason. */
  std::string message() const;

  ErrorCode code;

private:
  const char* text;
  uint64_t values[2];
};

/*! Thrown by functions that open, read or write files. */
class Error : public std::runtime_error {
public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code(code) {}

  const ErrorCode code;
};
} // namespace cvert
