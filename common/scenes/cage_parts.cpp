// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/cage_parts.h"

#include <map>
#include <tuple>

namespace programs {
namespace {

void addQuad(Cage& cage, unsigned a, unsigned b, unsigned c, unsigned d) {
  for (unsigned i : {a, b, c, d}) cage.faceIndices.push_back(i);
  cage.faceSizes.push_back(4);
}

/* Four sides need one quad; eight need four quads around a middle vertex. */
void addCap(Cage& cage, unsigned ring, int sides, Vec3f center, bool first) {
  const auto at = [&](int i) { return ring + unsigned(((first ? sides - i : i) + sides) % sides); };
  if (sides == 4) return addQuad(cage, at(0), at(1), at(2), at(3));
  const unsigned middle = unsigned(cage.positions.size());
  cage.positions.push_back(center);
  for (int i = 0; i < sides; i += 2) addQuad(cage, middle, at(i - 1), at(i), at(i + 1));
}

} // namespace

void appendTube(Cage& cage, const std::vector<Station>& stations, int sides) {
  const unsigned first = unsigned(cage.positions.size());
  for (const Station& s : stations)
    for (int i = 0; i < sides; i++) {
      const float angle = 2.0f * float(M_PI) * float(i) / float(sides);
      cage.positions.push_back(s.center + std::cos(angle) * s.a + std::sin(angle) * s.b);
    }
  const unsigned n = unsigned(sides);
  for (unsigned k = 0; k + 1 < stations.size(); k++)
    for (unsigned i = 0; i < n; i++) {
      const unsigned ring = first + k * n, next = (i + 1) % n;
      addQuad(cage, ring + i, ring + next, ring + n + next, ring + n + i);
    }
  addCap(cage, first, sides, stations.front().center, true);
  addCap(cage, first + unsigned(stations.size() - 1) * n, sides, stations.back().center, false);
}

void appendHorn(Cage& cage, const Horn& horn) {
  const Vec3f d = normalize(horn.direction);
  const Vec3f across = normalize(cross(d, horn.bendTowards)), towards = cross(across, d);
  std::vector<Station> stations;
  for (int k = 0; k <= horn.stations; k++) {
    const float t = float(k) / float(horn.stations);
    const Vec3f tangent = normalize(d + 2.0f * horn.bend * t * towards);
    const float r = horn.radius * (k == horn.stations ? 0.08f : std::pow(1.0f - t, 0.75f));
    stations.push_back({horn.base + horn.length * (t * d + horn.bend * t * t * towards), r * cross(across, tangent),
                        r * horn.flatness * across});
  }
  appendTube(cage, stations, 4);
}

void appendBall(Cage& cage, Vec3f center, float radius, int steps) {
  std::map<std::tuple<int, int, int>, unsigned> vertices;
  const auto vertex = [&](int x, int y, int z) {
    const auto [found, fresh] = vertices.try_emplace({x, y, z}, unsigned(cage.positions.size()));
    if (fresh) {
      /* tan makes the angles equal */
      const auto even = [&](int i) { return std::tan(0.25f * float(M_PI) * (2.0f * float(i) / float(steps) - 1.0f)); };
      cage.positions.push_back(center + radius * normalize(Vec3f{even(x), even(y), even(z)}));
    }
    return found->second;
  };
  for (int axis = 0; axis < 3; axis++)
    for (int end : {0, steps})
      for (int i = 0; i < steps; i++)
        for (int j = 0; j < steps; j++) {
          const auto at = [&](int a, int b) {
            return axis == 0 ? vertex(end, a, b) : axis == 1 ? vertex(b, end, a) : vertex(a, b, end);
          };
          const unsigned q[4] = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
          if (end) addQuad(cage, q[0], q[1], q[2], q[3]);
          else addQuad(cage, q[3], q[2], q[1], q[0]);
        }
}

} // namespace programs
