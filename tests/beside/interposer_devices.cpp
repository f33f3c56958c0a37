// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The interposer's settings of devices. Needs no Embree 4. */

#include "kernels/beside/interposer/devices.h"

#include <gtest/gtest.h>

namespace {

TEST(InterposerDevices, SettingsAreKeptUntilTheLastReferenceIsReleased)
{
  interposer::Devices devices;
  const char a = 0, b = 0;
  devices.add(&a, "threads=1");
  devices.add(&b, "threads=2");
  devices.retain(&a);
  devices.release(&a);
  EXPECT_EQ(devices.settingsOf(&a), "threads=1");
  devices.release(&a);
  EXPECT_EQ(devices.settingsOf(&a), "");
  EXPECT_EQ(devices.settingsOf(&b), "threads=2");
  EXPECT_EQ(devices.size(), 1u);
  devices.release(&b);
  EXPECT_EQ(devices.size(), 0u);
}

TEST(InterposerDevices, UnknownDevicesAreNotStored)
{
  interposer::Devices devices;
  const char unknown = 0;
  EXPECT_EQ(devices.settingsOf(&unknown), "");
  devices.retain(&unknown);
  devices.release(&unknown);
  devices.release(nullptr);
  EXPECT_EQ(devices.size(), 0u);
}

TEST(InterposerDevices, NewDeviceWithAReleasedHandleHasItsOwnSettings)
{
  interposer::Devices devices;
  const char device = 0;
  devices.add(&device, "threads=1");
  devices.release(&device);
  devices.add(&device, "");
  EXPECT_EQ(devices.settingsOf(&device), "");
  devices.release(&device);
  EXPECT_EQ(devices.size(), 0u);
}

} // namespace
