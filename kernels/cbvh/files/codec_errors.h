// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Errors of the codec as Embree's. */

#include "../embree/scene.h"
#include "../base/codec.h"
#include "../../cvert/basics/reason.h"

namespace embree
{
  namespace cbvh
  {
    /*! Calls function() and returns its result. Throws Embree's error in place of the codec's. */
    template<typename Function>
    auto withEmbreeErrors (const Function& function) -> decltype(function())
    {
      try { return function(); }
      catch (const cvert::Error& error) {
        throw_RTCError(error.code == cvert::ErrorCode::INVALID_OPERATION ? RTC_ERROR_INVALID_OPERATION : RTC_ERROR_INVALID_ARGUMENT,error.what());
      }
    }
  }
}
