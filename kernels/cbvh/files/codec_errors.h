// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include "../base/codec.h"
#include "../../cvert/basics/reason.h"

namespace embree
{
  namespace cbvh
  {
    /*! Returns the result of function(). Rethrows errors of the codec as errors of Embree. */
    template<typename Function>
    auto withEmbreeErrors (const Function& function) -> decltype(function())
    {
      try { return function(); }
      catch (const cvert::Error& error) {
        throw_RTCError(error.code == cvert::ErrorCode::INVALID_OPERATION ? RTC_ERROR_INVALID_OPERATION
                                                                         : RTC_ERROR_INVALID_ARGUMENT,error.what());
      }
    }
  }
}
