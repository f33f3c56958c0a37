// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target: arbitrary vertices for the encoder of cVERT, on or off a lattice, with one or several time steps.
// Decoding returns the same floats except for the sign of 0, and NaN for vertices that are not finite. The block is
// valid, fits into its memory, and has the same bytes if encoded again.

#include "fuzz_input.h"

#include "kernels/cvert/encoder/motion_encoder.h"
#include "kernels/cvert/encoder/lattice.h"
#include "kernels/cvert/decoder/validate.h"
#include "kernels/cvert/decoder/decoded_block.h"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace programs::test {
namespace {

using namespace cvert;

// Precedes the vertices.
struct Input {
  uint8_t quadsX, quadsY; // minus 1, modulo 16
  int8_t exponent;        // of the lattice
  // bit 0: vertices are snapped; 1: edges; 2: 16-bit integers instead of floats; 3: moves; 4..6: number of later
  // steps, minus 1
  uint8_t form;
};

bool sameVertex(float decoded, float given) {
  return std::memcmp(&decoded, &given, sizeof(float)) == 0 || (decoded == 0 && given == 0);
}

typedef std::vector<std::vector<std::array<float, 3>>> Steps; // vertices row by row

std::vector<uint8_t> bytesOf(const Steps& steps, const VertPlacement& at, float spacing) {
  if (steps.size() > 1) {
    auto encoder = std::make_unique<MotionEncoder>();
    std::vector<uint64_t> words(MotionEncoder::maxBytes(steps.size()) / 8 + 4, 0xA5A5A5A5A5A5A5A5u);
    uint8_t* const block = (uint8_t*)((uintptr_t(words.data()) + 15) & ~uintptr_t(15));
    encoder->begin(at, 0, 1, uint32_t(steps.size()), block);
    for (const auto& step : steps) {
      for (size_t v = 0; v < step.size(); v++) std::copy(step[v].begin(), step[v].end(), encoder->vertices()[v]);
      encoder->addStep();
    }
    MotionStatistics statistics;
    const size_t size = encoder->finish(statistics);
    REQUIRE(size <= MotionEncoder::maxBytes(steps.size()));
    return std::vector<uint8_t>(block, block + size);
  }
  auto encoder = std::make_unique<VertEncoder>();
  for (size_t v = 0; v < steps[0].size(); v++) std::copy(steps[0][v].begin(), steps[0][v].end(), encoder->vertices[v]);
  std::vector<uint8_t> bytes(VertEncoder::maxBytes, 0xA5);
  VertStatistics statistics;
  bytes.resize(encoder->encode(at, bytes.data(), statistics));
  return bytes;
}

void encode(const uint8_t* data, size_t size) {
  Input input;
  if (size < sizeof(input)) return;
  std::memcpy(&input, data, sizeof(input));
  data += sizeof(input);
  size -= sizeof(input);
  const uint32_t quadsX = 1 + input.quadsX % 16, quadsY = 1 + input.quadsY % 16, count = (quadsX + 1) * (quadsY + 1);
  const WorldLattice lattice(std::min(std::max(int(input.exponent), minLatticeExponent), maxLatticeExponent));
  const bool isSnapped = input.form & 1, areIntegers = input.form & 4;
  const uint32_t numSteps = input.form & 8 ? 2 + ((input.form >> 4) & 7) : 1;
  Steps steps(numSteps, std::vector<std::array<float, 3>>(count));
  const size_t width = areIntegers ? sizeof(int16_t) : sizeof(float);
  for (size_t i = 0; i < 3 * size_t(count) * numSteps; i++) {
    float& x = steps[i / 3 / count][i / 3 % count][i % 3];
    x = 0;
    if ((i + 1) * width <= size) {
      int16_t integer;
      if (areIntegers) {
        std::memcpy(&integer, data + i * width, width);
        x = float(integer) * lattice.spacing;
      } else std::memcpy(&x, data + i * width, width);
    }
    if (isSnapped) x = lattice.snap(x);
  }
  VertPlacement at(packRegion(quadsX, quadsY, 0, 0), packPatchQuads(quadsX, quadsY));
  if (input.form & 2) at = VertPlacement(at.region, at.patchQuads, packEdges(1, quadsY, quadsX, 1, 5, 1));

  const std::vector<uint8_t> first = bytesOf(steps, at, lattice.spacing), second = bytesOf(steps, at, lattice.spacing);
  REQUIRE(first == second);
  const bool hasVertex = std::any_of(steps.begin(), steps.end(), [](const auto& step) {
    return std::any_of(step.begin(), step.end(), [](const auto& v) { return isFinite(v.data()); });
  });
  REQUIRE(hasVertex == !first.empty());
  if (first.empty()) return;
  const ExactMemory exact(first.data(), first.size(), 16);
  const VertHeader* block = (const VertHeader*)exact.get();
  REQUIRE(!validateVert(block, first.size()));
  REQUIRE(((vertBytes(block) + 3) & ~3u) == first.size());
  for (uint32_t s = 0; s < numSteps; s++) {
    const auto decoded = std::make_unique<DecodedBlock>(block, s);
    for (uint32_t v = 0; v < count; v++)
      for (int k = 0; k < 3; k++)
        REQUIRE(isFinite(steps[s][v].data()) ? sameVertex(decoded->vertices[v][k], steps[s][v][k])
                                             : std::isnan(decoded->vertices[v][k]));
  }
}

} // namespace

void writeSeeds(const std::string& folder) {
  for (int n = 0; n < 12; n++) {
    std::vector<uint8_t> bytes(sizeof(Input) + 6 * 17 * 17 * (n < 3 ? 1 : 2 + (n & 3)));
    bytes[0] = uint8_t(n % 2 ? 15 : 6);
    bytes[1] = uint8_t(n % 3 ? 15 : 3);
    bytes[3] = uint8_t(5 | (n & 2) | (n < 3 ? 0 : 8 | (n & 3) << 4));
    for (size_t i = sizeof(Input); i < bytes.size(); i++) bytes[i] = uint8_t((i * i >> n) % (n < 4 ? 3 : 200));
    writeSeed(folder + "/" + std::to_string(n), std::string(bytes.begin(), bytes.end()));
  }
}

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  ::programs::test::encode(data, size);
  return 0;
}
