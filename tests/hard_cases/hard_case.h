// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hard cases: one test for each case, representation and ISA. A test records its property as a sentence, which
 * scripts/report.py shows in the table of hard cases. */

#include "support/random.h"
#include "support/scene.h"

#include <ostream>

namespace programs::test {

struct Tracer {
  RTCCompression compression;
  std::string isa; // as in the device string: isa=avx2
};

inline std::ostream& operator<<(std::ostream& out, const Tracer& tracer) {
  return out << kindName(tracer.compression) << ", " << tracer.isa;
}

// cLEAF_avx2, and sse42 for sse4.2: GoogleTest requires names of letters and digits.
inline std::string tracerName(const testing::TestParamInfo<Tracer>& info) {
  std::string name = std::string(kindName(info.param.compression)) + "_";
  for (char c : info.param.isa.substr(4))
    if (c != '.') name += c;
  return name;
}

inline std::vector<Tracer> tracers() {
  std::vector<Tracer> list;
  for (RTCCompression compression :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT})
    for (const char* isa : {TEST_ISAS}) list.push_back({compression, isa});
  return list;
}

class HardCase : public testing::TestWithParam<Tracer> {
protected:
  Device device{GetParam().isa + ",threads=1"};

  RTCCompression compression() const { return GetParam().compression; }

  void SetUp() override {
    if (!device) GTEST_SKIP() << "this machine does not support " << GetParam().isa;
  }
  void TearDown() override {
    if (device) { EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message; }
  }

  // Records the property that the test checks, as a sentence.
  void property(const std::string& sentence) { RecordProperty("property", sentence); }
};

} // namespace programs::test
