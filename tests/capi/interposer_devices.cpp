// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The interposer's settings of devices and sizes of buffers. Needs no Embree 4. */

#include "kernels/interposer/devices.h"

#include <gtest/gtest.h>

namespace {

TEST(InterposerDevices, SettingsAreKeptUntilTheLastReferenceIsReleased) {
  interposer::Devices devices;
  const char a = 0, b = 0;
  devices.add(&a, "threads=1");
  devices.add(&b, "threads=2");
  EXPECT_TRUE(devices.retain(&a));
  devices.release(&a);
  EXPECT_TRUE(devices.contains(&a));
  EXPECT_EQ(devices.settingsOf(&a), "threads=1");
  devices.release(&a);
  EXPECT_FALSE(devices.contains(&a));
  EXPECT_EQ(devices.settingsOf(&a), "");
  EXPECT_EQ(devices.settingsOf(&b), "threads=2");
  EXPECT_EQ(devices.size(), 1u);
  devices.release(&b);
  EXPECT_EQ(devices.size(), 0u);
}

TEST(InterposerDevices, UnknownDevicesAreNotStored) {
  interposer::Devices devices;
  const char unknown = 0;
  EXPECT_EQ(devices.settingsOf(&unknown), "");
  EXPECT_FALSE(devices.retain(&unknown));
  EXPECT_FALSE(devices.contains(&unknown));
  devices.release(&unknown);
  devices.release(nullptr);
  EXPECT_EQ(devices.size(), 0u);
}

TEST(InterposerDevices, NewDeviceWithAReleasedHandleHasItsOwnSettings) {
  interposer::Devices devices;
  const char device = 0;
  devices.add(&device, "threads=1");
  devices.release(&device);
  devices.add(&device, "");
  EXPECT_EQ(devices.settingsOf(&device), "");
  devices.release(&device);
  EXPECT_EQ(devices.size(), 0u);
}

TEST(InterposerDevices, RangesPastTheEndOfABufferAreFound) {
  interposer::Handles<interposer::BufferSize> buffers;
  const char a = 0, unknown = 0;
  buffers.add(&a, {100, false});
  const interposer::BufferSize size = buffers.propertiesOf(&a);
  EXPECT_FALSE(size.isExceededBy(4, 12, 12, 8));
  EXPECT_FALSE(size.isExceededBy(8, 16, 12, 6));
  EXPECT_FALSE(size.isExceededBy(88, 0, 12, 1000));
  EXPECT_FALSE(size.isExceededBy(1000, 12, 12, 0));
  EXPECT_TRUE(size.isExceededBy(5, 12, 12, 8));
  EXPECT_TRUE(size.isExceededBy(4, 12, 12, 9));
  EXPECT_TRUE(size.isExceededBy(89, 0, 12, 1));
  EXPECT_TRUE(size.isExceededBy(SIZE_MAX - 4, 12, 12, 1));
  EXPECT_TRUE(size.isExceededBy(0, SIZE_MAX / 2 + 1, 12, 3)) << "the product overflows";
  EXPECT_TRUE((interposer::BufferSize{8, false}.isExceededBy(0, 12, 12, 1)));
  EXPECT_TRUE((interposer::BufferSize{100, true}.isExceededBy(8, 16, 12, 6))) << "the range ends within a stride";
  EXPECT_FALSE((interposer::BufferSize{104, true}.isExceededBy(8, 16, 12, 6)));
  EXPECT_FALSE(buffers.propertiesOf(&unknown).isExceededBy(5, 12, 12, 1000000));
}

} // namespace
