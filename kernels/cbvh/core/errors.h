// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Errors of the functions in this folder, for interfaces that see nothing of Embree's internals. The functions throw
 * Embree's rtcore_error, and std::bad_alloc if memory runs out. rtc functions catch them by RTC_CATCH_END; other
 * interfaces call caughtError(). */

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

    /*! Returns the code and the text of the exception that is being handled. Call it in a catch block. An exception
     *  that is not Embree's is RTC_ERROR_UNKNOWN. */
    CaughtError caughtError ();

    /*! Throws RTC_ERROR_INVALID_ARGUMENT. */
    [[noreturn]] void invalidArgument (const std::string& text);
  }
}
