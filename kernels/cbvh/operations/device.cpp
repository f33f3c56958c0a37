// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "device.h"
#include "../embree/scene.h"

namespace embree::core {
Device* newDevice(const char* deviceString) {
  static MutexSys mutex; // like rtcNewDevice's
  Lock<MutexSys> lock(mutex);
  Device* const device = new Device(deviceString);
  device->refInc();
  return device;
}

Device* deviceOf(Geometry* geometry) { return geometry->device; }

Device* deviceOf(Scene* scene) { return scene->device; }

unsigned numPrimitives(Geometry* geometry) { return geometry->size(); }

void raiseError(Device* device, RTCError code, const char* text) { Device::process_error(device, code, text); }
} // namespace embree::core
