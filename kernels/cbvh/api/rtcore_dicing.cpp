// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "structs.h"
#include "../core/dicing.h"

using namespace embree;

namespace
{
  DicingCamera cameraOf (const RTCDicingArguments& args)
  {
    DicingCamera camera;
    std::copy_n(args.position,3,camera.position);
    std::copy_n(args.direction,3,camera.direction);
    std::copy_n(args.up,3,camera.up);
    camera.orthographic = args.orthographic;
    camera.pixelSize = args.pixelSize;
    camera.width = args.width;
    camera.height = args.height;
    camera.transform = args.transform;
    camera.quadSize = args.quadSize;
    camera.outside = args.outside;
    camera.maxRate = args.maxRate;
    camera.maxRates = args.maxRates;
    return camera;
  }
}

RTC_NAMESPACE_BEGIN;

RTC_API void rtcDiceGeometry (RTCGeometry hgeometry, const struct RTCDicingArguments* args)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  require(geometry,"geometry");
  require(args,"args");
  core::dice(geometry,cameraOf(core::readStruct(args)));
  RTC_CATCH_END2(geometry);
}

RTC_NAMESPACE_END
