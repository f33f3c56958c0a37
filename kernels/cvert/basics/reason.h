// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Why input is rejected. Functions that check bytes return a Reason, allocate nothing and throw nothing; functions that open or write files
 * throw an Error. Callers turn both into errors of their own interface. */

#include <cstdint>
#include <stdexcept>
#include <string>

namespace cvert
{
  enum class ErrorCode : uint32_t
  {
    NONE,
    DAMAGED,           //!< the bytes contradict each other or the format
    UNSUPPORTED,       //!< a version or a part of the format that this library does not read
    INVALID_ARGUMENT,  //!< a path, or a request
    INVALID_OPERATION  //!< an object that is not in the state for it, or a disk that is full
  };

  class Reason
  {
  public:
    /*! Nothing is wrong. */
    Reason () : code(ErrorCode::NONE), text(""), values{ 0,0 } {}

    /*! text: of static storage; each % in it stands for the next value */
    Reason (ErrorCode code, const char* text, uint64_t first = 0, uint64_t second = 0) : code(code), text(text), values{ first,second } {}

    static Reason damaged (const char* text, uint64_t first = 0, uint64_t second = 0) { return Reason(ErrorCode::DAMAGED,text,first,second); }
    static Reason unsupported (const char* text, uint64_t first = 0, uint64_t second = 0) { return Reason(ErrorCode::UNSUPPORTED,text,first,second); }

    /*! True if something is wrong. */
    explicit operator bool () const { return code != ErrorCode::NONE; }

    /*! The text with its values. */
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
