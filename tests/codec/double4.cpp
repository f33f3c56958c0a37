// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Operations on four doubles return the same bits as on one double, in registers of any kind, also for NaN, infinity
 * and values that no integer holds. */

#include "kernels/cvert/portable/double4.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace programs::test { namespace {

using cvert::Double4;
using cvert::Float4;
using cvert::Int4;
using cvert::Mask4;

using Lanes = double[4];

Double4 load(const Lanes& a) { return Double4::load(a); }

// The bits of a NaN differ between processors.
template<typename T>
bool isSame(T a, T b) {
  return (a != a && b != b) || std::memcmp(&a, &b, sizeof(T)) == 0;
}

template<typename Expected>
void expectLanes(Double4 found, const Expected& expected, const char* what) {
  Lanes lanes;
  found.store(lanes);
  for (int i = 0; i < 4; i++)
    EXPECT_TRUE(isSame(lanes[i], double(expected(i))))
        << what << ", lane " << i << ": " << lanes[i] << ", not " << expected(i);
}

template<typename Expected>
uint32_t bitsWhere(const Expected& isTrue) {
  uint32_t bits = 0;
  for (int i = 0; i < 4; i++) bits |= uint32_t(isTrue(i)) << i;
  return bits;
}

double oddNumber(Random& random) {
  static const double special[] = {
      0.0,          -0.0,          1.0,           NAN,           INFINITY, -INFINITY, 2147483647.0, 2147483647.5,
      2147483648.0, -2147483648.0, -2147483648.5, -2147483649.0, 1e300,    -1e300,    0.5,          -0.5};
  if (random.chance(0.3)) return special[random.below(sizeof(special) / sizeof(*special))];
  return random.normal() * std::exp2(random.uniform(-40, 40));
}

TEST(Double4, EqualsFourDoubles) {
  Random random(71);
  for (int n = 0; n < 20000 && !testing::Test::HasFailure(); n++) {
    SCOPED_TRACE(n);
    Lanes a, b;
    float f[4];
    int integers[4];
    for (int i = 0; i < 4; i++) {
      a[i] = oddNumber(random);
      b[i] = random.chance(0.2) ? a[i] : oddNumber(random);
      f[i] = float(a[i]);
      integers[i] = int(random.below(1u << 31)) - (1 << 30);
    }
    const uint32_t bits = random.below(16);
    const Double4 A = load(a), B = load(b);
    const Mask4 mask = cvert::maskFromBits(bits);

    expectLanes(A + B, [&](int i) { return a[i] + b[i]; }, "+");
    expectLanes(A - B, [&](int i) { return a[i] - b[i]; }, "-");
    expectLanes(A * B, [&](int i) { return a[i] * b[i]; }, "*");
    expectLanes(cvert::product(A, B), [&](int i) { return a[i] * b[i]; }, "product");
    expectLanes(A / B, [&](int i) { return a[i] / b[i]; }, "/");
    expectLanes(cvert::min(A, B), [&](int i) { return b[i] < a[i] ? b[i] : a[i]; }, "min");
    expectLanes(cvert::max(A, B), [&](int i) { return b[i] > a[i] ? b[i] : a[i]; }, "max");
    expectLanes(cvert::abs(A), [&](int i) { return std::fabs(a[i]); }, "abs");
    expectLanes(cvert::select(mask, A, B), [&](int i) { return bits >> i & 1 ? a[i] : b[i]; }, "select");
    expectLanes(mask & A, [&](int i) { return bits >> i & 1 ? a[i] : 0.0; }, "&");
    expectLanes(Double4(Float4::load(f)), [&](int i) { return f[i]; }, "of floats");
    expectLanes(cvert::toDouble(Int4::load(integers)), [&](int i) { return integers[i]; }, "of integers");
    expectLanes(cvert::broadcast<1>(A), [&](int) { return a[1]; }, "broadcast<1>");
    expectLanes(cvert::broadcast<2>(A), [&](int) { return a[2]; }, "broadcast<2>");

    EXPECT_EQ(mask.bits(), bits);
    EXPECT_EQ((A < B).bits(), bitsWhere([&](int i) { return a[i] < b[i]; }));
    EXPECT_EQ((A <= B).bits(), bitsWhere([&](int i) { return a[i] <= b[i]; }));
    EXPECT_EQ((mask & (A < B)).bits(), bits & bitsWhere([&](int i) { return a[i] < b[i]; }));
    EXPECT_EQ((mask | (A < B)).bits(), bits | bitsWhere([&](int i) { return a[i] < b[i]; }));

    float floats[4];
    cvert::toFloat(A).store(floats);
    for (int i = 0; i < 4; i++) EXPECT_TRUE(isSame(floats[i], float(a[i]))) << "to float: " << a[i];
    int whole[4];
    cvert::toInt(A).store(whole);
    for (int i = 0; i < 4; i++)
      EXPECT_EQ(whole[i], a[i] > -2147483649.0 && a[i] < 2147483648.0 ? int(a[i]) : std::numeric_limits<int>::min())
          << a[i];
    (mask & Int4::load(integers)).store(whole);
    for (int i = 0; i < 4; i++) EXPECT_EQ(whole[i], bits >> i & 1 ? integers[i] : 0);

    EXPECT_TRUE(isSame(cvert::cross2D(A, B), a[0] * b[1] - a[1] * b[0]));
    const double less[2] = {a[0] < a[2] ? a[0] : a[2], a[1] < a[3] ? a[1] : a[3]};
    const double more[2] = {a[0] > a[2] ? a[0] : a[2], a[1] > a[3] ? a[1] : a[3]};
    EXPECT_TRUE(isSame(cvert::reduceMin(A), less[0] < less[1] ? less[0] : less[1]));
    EXPECT_TRUE(isSame(cvert::reduceMax(A), more[0] > more[1] ? more[0] : more[1]));
  }
}

}} // namespace programs::test
