// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reasons for which input is rejected. Functions that check bytes return a Reason; they do not allocate or throw.
 * Functions that open or write files throw an Error. Callers convert both to errors of their own interface. */

#include <cstdint>
#include <stdexcept>
#include <string>

namespace cvert
{
  enum class ErrorCode : uint32_t
  {
    NONE,
    DAMAGED,           //!< the bytes contradict each other or the format
    UNSUPPORTED,       //!< version or part of the format that this library does not read
    INVALID_ARGUMENT,  //!< invalid path or request
    INVALID_OPERATION  //!< object in the wrong state, or disk full
  };

  class Reason
  {
  public:
    /*! No error. */
    Reason () : code(ErrorCode::NONE), text(""), values{ 0,0 } {}

    /*! text: must have static storage. Each % is replaced by the next value. */
    Reason (ErrorCode code, const char* text, uint64_t first = 0, uint64_t second = 0)
      : code(code), text(text), values{ first,second } {}

    static Reason damaged (const char* text, uint64_t first = 0, uint64_t second = 0) {
      return Reason(ErrorCode::DAMAGED,text,first,second);
    }
    static Reason unsupported (const char* text, uint64_t first = 0, uint64_t second = 0) {
      return Reason(ErrorCode::UNSUPPORTED,text,first,second);
    }

    /*! True if there is an error. */
    explicit operator bool () const { return code != ErrorCode::NONE; }

    /*! The text with its values filled in. */
    std::string message () const;

    ErrorCode code;

  private:
    const char* text;
    uint64_t values[2];
  };

  class Error : public std::runtime_error
  {
  public:
    Error (ErrorCode code, const std::string& message) : std::runtime_error(message), code(code) {}

    const ErrorCode code;
  };
}
