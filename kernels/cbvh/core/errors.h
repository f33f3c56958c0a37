// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Functions of this folder throw Embree's rtcore_error or std::bad_alloc. rtc functions catch them with RTC_CATCH_END,
 * interfaces without Embree's internal headers with caughtError(). */

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

    /*! Call it in a catch block. Other exceptions become RTC_ERROR_UNKNOWN. */
    CaughtError caughtError ();

    /*! Throws RTC_ERROR_INVALID_ARGUMENT. For code without Embree's internal headers. */
    [[noreturn]] void throwInvalidArgument (const std::string& text);
  }
}
