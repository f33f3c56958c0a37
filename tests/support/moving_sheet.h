// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Moving sheets of quads on lattices, the input of moving cVERT blocks. */

#include "kernels/cvert/encoder/lattice.h"
#include "kernels/cvert/encoder/motion_encoder.h"
#include "support/random.h"

#include <array>
#include <cmath>
#include <vector>

namespace programs::test {

enum class SheetMotion { turn, grow, bend, shake };

struct MovingSheet {
  typedef std::vector<std::array<float, 3>> Step;

  uint32_t quadsX, quadsY;
  std::vector<float> spacings;
  std::vector<Step> steps;

  // A sheet whose kind depends on i. Includes vertices that are not finite and steps at large distances.
  MovingSheet(Random& random, uint32_t quadsX, uint32_t quadsY, int i)
    : MovingSheet(random, quadsX, quadsY, SheetMotion(i % 4), std::vector<double>{0, 0.5, 5, 40, 4000}[i % 5],
                  i % 50 == 0 ? 129 : 2 + random.below(5)) {
    if (i % 7 == 0)
      steps[random.below(uint32_t(steps.size()))][random.below(uint32_t(steps[0].size()))][i % 3] =
          i % 2 ? NAN : INFINITY;
    if (i % 31 == 0) std::fill(steps[i % 2].begin(), steps[i % 2].end(), std::array<float, 3>{NAN, 0, 0});
    if (i % 13 == 5) // not on a lattice
      for (auto& p : steps[random.below(uint32_t(steps.size()))])
        for (float& c : p) c *= 0.7123f;
    if (i % 11 == 0) snap(uint32_t(steps.size()) - 1, std::ldexp(spacings[0], int(random.below(9)) - 4));
  }

  // A sheet with a rough surface. roughness: in lattice spacings.
  MovingSheet(Random& random, uint32_t quadsX, uint32_t quadsY, SheetMotion motion, double roughness, uint32_t numSteps)
    : quadsX(quadsX),
      quadsY(quadsY) {
    const float spacing = std::ldexp(1.0f, int(random.below(60)) - 30);
    double place[3], axis[3];
    for (int k = 0; k < 3; k++) {
      place[k] = random.uniform(-4e5, 4e5);
      axis[k] = random.normal();
    }
    const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]),
                 total = random.uniform(0.1, 0.6);
    std::vector<double> heights;
    for (uint32_t v = 0; v < (quadsX + 1) * (quadsY + 1); v++) heights.push_back(roughness * random.normal());
    for (uint32_t s = 0; s < numSteps; s++) {
      const double f = total * s / (numSteps - 1.0);
      Step step;
      for (uint32_t y = 0; y <= quadsY; y++)
        for (uint32_t x = 0; x <= quadsX; x++) {
          double p[3] = {36.0 * x, 36.0 * y,
                         heights[y * (quadsX + 1) + x] + 0.05 * (double(x) * x - 0.3 * double(y) * y)},
                 q[3];
          if (motion == SheetMotion::bend) p[2] += f * double(x) * x, p[1] += f * double(y);
          if (motion == SheetMotion::grow)
            for (double& c : p) c *= 1 + f;
          if (motion == SheetMotion::shake)
            for (double& c : p) c += s * (roughness + 1) * random.normal();
          const double angle = motion == SheetMotion::turn ? f : 0.3;
          turn(p, axis, length, angle, q);
          step.push_back({float((q[0] + place[0]) * spacing), float((q[1] + place[1]) * spacing),
                          float((q[2] + place[2]) * spacing)});
        }
      steps.push_back(step);
      spacings.push_back(spacing);
      snap(s, spacing);
    }
  }

  // Some time steps of another sheet.
  MovingSheet(const MovingSheet& other, const std::vector<uint32_t>& of) : quadsX(other.quadsX), quadsY(other.quadsY) {
    for (uint32_t s : of) {
      steps.push_back(other.steps[s]);
      spacings.push_back(other.spacings[s]);
    }
  }

  void snap(uint32_t step, float spacing) {
    spacings[step] = spacing;
    const cvert::WorldLattice lattice(std::ilogb(spacing));
    for (auto& p : steps[step])
      for (float& c : p) c = lattice.snap(c);
  }

private:
  static void turn(const double p[3], const double axis[3], double length, double angle, double out[3]) {
    double n[3], dot = 0;
    for (int k = 0; k < 3; k++) {
      n[k] = axis[k] / length;
      dot += n[k] * p[k];
    }
    for (int k = 0; k < 3; k++) {
      const double cross = n[(k + 1) % 3] * p[(k + 2) % 3] - n[(k + 2) % 3] * p[(k + 1) % 3];
      out[k] = p[k] * std::cos(angle) + cross * std::sin(angle) + n[k] * dot * (1 - std::cos(angle));
    }
  }
};

struct EncodedMotion {
  std::vector<uint64_t> words; // block() aligns to 16 bytes
  size_t size = 0;
  cvert::MotionStatistics statistics;

  EncodedMotion(cvert::MotionEncoder& encoder, const MovingSheet& sheet)
    : EncodedMotion(
          encoder, sheet,
          {cvert::packRegion(sheet.quadsX, sheet.quadsY, 0, 0), cvert::packPatchQuads(sheet.quadsX, sheet.quadsY)}) {}

  EncodedMotion(cvert::MotionEncoder& encoder, const MovingSheet& sheet, const cvert::VertPlacement& at) {
    words.resize(cvert::MotionEncoder::maxBytes(sheet.steps.size()) / 8 + 4);
    encoder.begin(at, 0.0f, 1.0f, uint32_t(sheet.steps.size()), (uint8_t*)block());
    for (size_t s = 0; s < sheet.steps.size(); s++) {
      for (size_t v = 0; v < sheet.steps[s].size(); v++)
        std::copy(sheet.steps[s][v].begin(), sheet.steps[s][v].end(), encoder.vertices()[v]);
      encoder.addStep();
    }
    size = encoder.finish(statistics);
  }

  cvert::VertHeader* block() { return (cvert::VertHeader*)((uintptr_t(words.data()) + 15) & ~uintptr_t(15)); }
  const cvert::VertHeader* block() const {
    return (const cvert::VertHeader*)((uintptr_t(words.data()) + 15) & ~uintptr_t(15));
  }

  size_t firstStepBytes() const { return size - statistics.stepBytes; }
};

} // namespace programs::test
