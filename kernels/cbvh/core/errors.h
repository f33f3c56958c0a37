// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Errors of the functions in this folder: Embree's rtcore_error, and std::bad_alloc if memory runs out. rtc functions
 * catch them with RTC_CATCH_END. Interfaces that do not include Embree call caughtError(). */

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

    /*! Returns the exception that is being handled; call it in a catch block. Exceptions that are not Embree's are
     *  RTC_ERROR_UNKNOWN. */
    CaughtError caughtError ();

    [[noreturn]] void invalidArgument (const std::string& text);
  }
}
