// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts errors of the codec to Embree's errors. */

#include "../embree/scene.h"
#include "../base/codec.h"
#include "../../cvert/basics/reason.h"

namespace embree
{
  namespace cbvh
  {
    /*! Calls function() and returns its result. Throws an error of Embree if function() throws an error of the
     *  codec. */
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
