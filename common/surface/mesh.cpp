// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/mesh.h"
#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/hash.h"
#include "basics/progress.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <unordered_map>

namespace programs {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

} // namespace

float latticeSpacing(const std::vector<Vec3f>& positions) {
  int lowest = 1000, highest = -1000; // exponents of the common divisor and the largest coordinate
  for (const Vec3f& p : positions)
    for (float x : {p.x, p.y, p.z}) {
      if (x == 0.0f || !std::isfinite(x)) continue;
      int exponent;
      const int mantissa = int(std::ldexp(std::frexp(std::fabs(x), &exponent), 24));
      lowest = std::min(lowest, exponent - 24 + __builtin_ctz(unsigned(mantissa)));
      highest = std::max(highest, exponent);
    }
  return lowest > highest - 24 && lowest <= highest ? std::ldexp(1.0f, lowest) : 0.0f;
}

void writeObj(const std::string& path, const std::vector<Vec3f>& vertices,
              const std::vector<std::array<unsigned, 4>>& quads) {
  Phase phase(path);
  PendingFile pending(path);
  std::unique_ptr<std::FILE, CloseFile> file(std::fopen(pending.temporary().c_str(), "w"));
  if (!file) throw Error(path + ": " + std::strerror(errno));
  std::fprintf(file.get(), "# %s\n", objSplitComment);
  std::unordered_map<std::array<uint32_t, 3>, unsigned, ArrayHash> known;
  std::vector<unsigned> number(vertices.size()); // from 1; 0 for vertices that are not finite
  for (size_t i = 0; i < vertices.size(); i++) {
    const Vec3f p = vertices[i] + Vec3f{0, 0, 0}; // turns -0 into 0
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    std::array<uint32_t, 3> bits;
    std::memcpy(bits.data(), &p, sizeof(bits));
    const auto found = known.emplace(bits, unsigned(known.size() + 1));
    number[i] = found.first->second;
    if (found.second) std::fprintf(file.get(), "v %.9g %.9g %.9g\n", double(p.x), double(p.y), double(p.z));
    if (i % 65536 == 0) {
      phase.update(0.5 * double(i) / double(vertices.size()));
      throwIfCanceled();
    }
  }
  for (const std::array<unsigned, 4>& quad : quads)
    if (std::all_of(quad.begin(), quad.end(), [&](unsigned v) { return number[v] != 0; }))
      std::fprintf(file.get(), "f %u %u %u %u\n", number[quad[0]], number[quad[1]], number[quad[2]], number[quad[3]]);
  if (std::fflush(file.get()) != 0 || std::ferror(file.get())) throw Error(path + ": " + std::strerror(errno));
  file.reset();
  pending.commit();
}

} // namespace programs
