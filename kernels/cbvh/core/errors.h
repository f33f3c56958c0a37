// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Errors of the functions in this folder, for interfaces that do not include Embree. The functions throw Embree's
 * rtcore_error, and std::bad_alloc if memory runs out. rtc functions catch them with RTC_CATCH_END. Other interfaces
 * call caughtError(). */

#include "../../../include/embree3/rtcore.h"
#include <string>

namespace embree
{
  namespace core
  {
    struct CaughtError
    {
      RTCError code;     //!< never RTC_ERROR_NONE
      std::string text;
    };

    /*! Returns the code and the text of the exception that is being handled. Must be called in a catch block.
     *  Exceptions that are not Embree's are RTC_ERROR_UNKNOWN. */
    CaughtError caughtError ();

    /*! Throws RTC_ERROR_INVALID_ARGUMENT. */
    [[noreturn]] void invalidArgument (const std::string& text);
  }
}
