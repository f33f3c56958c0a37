// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lossless encoder of a mesh block (format/mesh_block.h), except that -0, and denormal floats if the processor flushes
 * them, become 0. Callers may snap corners to a lattice first (mesh_lattice.h). Equal corners become one vertex.
 *
 * The spacing on an axis is the largest power of two that divides all vertices, or 2^-126 if all are equal. Ranks
 * (rankOfFloat) replace coordinates longer than maxMeshCoordinateBits, or than maxUnrankedBits if that saves bits. */

#include "../portable/bits.h"
#include "mesh_partition.h"
#include "mesh_position.h"
#include "mesh_strips.h"
#include <algorithm>
#include <cassert>
#include <cmath>

namespace cvert { inline namespace CVERT_ISA {
struct MeshTriangle {
  float corners[3][3]; //!< by corner and axis; finite; three different points unless vertices have IDs
  uint32_t number;     //!< primitive, or twice the primitive plus 0 or 1, see meshHasQuads
};

/*! Sums over all blocks. */
struct MeshStatistics {
  uint64_t blocks = 0, groups = 0, triangles = 0, vertices = 0, restarts = 0, bytes = 0;
  uint64_t topologyBits = 0, vertexBits = 0, numberBits = 0;
  uint64_t rankAxes = 0, shearedBlocks = 0;
  uint64_t stepBytes = 0; //!< of later steps of moving blocks, not part of `bytes`
};

class MeshEncoder {
public:
  /*! Upper bound of a block's size: 184 bytes of header, records and boxes, 1328 of topology, 12*496 of vertices,
   *  1088 of numbers. */
  static constexpr size_t maxBytes = 9216;

  MeshEncoder() { std::memset(slots, 0, sizeof(slots)); }

  /*! Encodes as many triangles as fit into a block. ends: see MeshGroups; groups with too many triangles, vertices or
   *  strips are divided. stored: receives the number of encoded triangles. block: maxBytes, aligned to 4. Returns the
   *  size in bytes, a multiple of 4. The caller then sets meshHasQuads, if necessary. */
  size_t encode(const MeshTriangle* triangles, const uint32_t* ends, uint32_t numGroups, uint32_t surface,
                uint8_t* block, uint32_t& stored, MeshStatistics& statistics) {
    begin();
    for (uint32_t g = 0; g < numGroups && groups < maxMeshGroups && numTriangles < maxMeshTriangles; g++)
      while (numTriangles < ends[g] && groups < maxMeshGroups && numTriangles < maxMeshTriangles)
        addGroup(triangles + numTriangles,
                 std::min(std::min(ends[g], maxMeshTriangles) - numTriangles, maxGroupTriangles));
    stored = numTriangles;
    for (int k = 0; k < 3; k++) chooseCoordinates(k);
    chooseShear();
    computeBounds();
    return write(surface, block, statistics);
  }

  /*! Encodes triangles that were decoded from a block, group by group, as that block. Requires corners without -0. */
  size_t encodeInOrder(const MeshTriangle* triangles, const MeshGroups& groups, uint32_t surface, uint8_t* block,
                       MeshStatistics& statistics) {
    uint32_t stored;
    keepsOrder = true;
    const size_t bytes = encode(triangles, groups.ends, groups.count, surface, block, stored, statistics);
    keepsOrder = false;
    return bytes;
  }

  /*! Encodes a cluster of MeshClusters. Calls onBlock(bytes,first,count) for each block: several if groups were
   *  divided. areHalvesOfQuads: consecutive triangles of a quad stay in one block. */
  template<typename OnBlock>
  void encodeCluster(const MeshTriangle* triangles, const MeshGroups& groups, bool areHalvesOfQuads, uint32_t surface,
                     uint8_t* block, MeshStatistics& statistics, const OnBlock& onBlock) {
    uint32_t stored, group = 0;
    for (uint32_t first = 0; group < groups.count; first += stored) {
      MeshGroups rest;
      for (uint32_t g = group; g < groups.count; g++) rest.add(groups.ends[g] - first);
      const MeshStatistics before = statistics;
      size_t bytes = encode(triangles + first, rest.ends, rest.count, surface, block, stored, statistics);
      // cutting the last group may divide it elsewhere, so that the block holds fewer triangles than it was cut to
      while (areHalvesOfQuads && first + stored < groups.numTriangles() &&
             triangles[first + stored].number == (triangles[first + stored - 1].number | 1)) {
        // a block that ends within a quad is full: it has maxMeshGroups groups, or maxMeshTriangles triangles
        assert(stored >= maxMeshGroups);
        for (uint32_t g = 0; g < rest.count; g++) rest.ends[g] = std::min(rest.ends[g], stored - 1);
        statistics = before;
        bytes = encode(triangles + first, rest.ends, rest.count, surface, block, stored, statistics);
      }
      onBlock(bytes, first, stored);
      while (group < groups.count && groups.ends[group] <= first + stored) group++;
    }
  }

protected:
  struct Group {
    uint32_t triangles, vertices, owned, restarts, repeats, firstVertex;
    uint32_t restartMask, fanMask, ownMask;
    uint64_t newMask; //!< a bit per entry of the stream
    uint8_t firstCorners[maxGroupTriangles], repeated[3 * maxGroupTriangles];
    uint16_t numbers[maxGroupVertices]; //!< vertices, as indices in the block
    uint32_t triangleNumbers[maxGroupTriangles];
    uint32_t lower[3], extent[3]; //!< box of the group
  };

  static const uint32_t slotCount = 2048; //!< of the hash table of corners; 11 bits, see findCorner
  static const uint16_t noNumber = 0xFFFF;

  void begin() {
    groups = numTriangles = numVertices = numCorners = attempt = 0;
    if (++epoch == 0) {
      std::memset(slots, 0, sizeof(slots));
      epoch = 1;
    }
  }

  /*! Returns the corner at a position. Adds it if it is new. */
  uint32_t cornerAt(const float p[3]) {
    const MeshPosition position(p);
    return findCorner(position, position.hash(), [&](uint32_t corner) {
      return std::memcmp(corners[corner], position.words, sizeof(position.words)) == 0;
    });
  }

  /*! Finds a corner in the hash table, or adds it. isSame(corner): true for the requested corner. */
  template<typename IsSame>
  uint32_t findCorner(const MeshPosition& position, uint32_t hash, const IsSame& isSame) {
    for (uint32_t i = hash >> 21;; i = (i + 1) % slotCount) {
      Slot& slot = slots[i];
      if (slot.epoch != epoch) {
        slot.epoch = epoch;
        slot.corner = numCorners;
        std::memcpy(corners[numCorners], position.words, sizeof(position.words));
        numberOf[numCorners] = noNumber;
        groupOf[numCorners] = ~0u;
        return numCorners++;
      }
      if (isSame(slot.corner)) return slot.corner;
    }
  }

  /*! If vertices have IDs, corners with different IDs differ, even at the same position. */
  uint32_t cornerOf(const MeshTriangle& triangle, int c) {
    if (!ids) return cornerAt(triangle.corners[c]);
    const uint32_t id = ids[&triangle - idsBegin][c], before = numCorners;
    const uint32_t corner = findCorner(MeshPosition(triangle.corners[c]), id * 0x9E3779B1u,
                                       [&](uint32_t corner) { return idOfCorner[corner] == id; });
    if (corner == before) idOfCorner[corner] = id;
    return corner;
  }

  /*! Adds a group of up to `count` triangles, fewer if they have too many vertices or strips. */
  void addGroup(const MeshTriangle* triangles, uint32_t count) {
    uint8_t local[maxGroupTriangles][3];
    uint32_t corner[maxGroupVertices];
    for (;; count /= 2) {
      uint32_t used = 0, vertices = 0;
      attempt++;
      for (; used < count; used++) {
        uint32_t own[3], fresh = 0;
        for (int c = 0; c < 3; c++) {
          own[c] = cornerOf(triangles[used], c);
          fresh += groupOf[own[c]] != attempt;
        }
        if (vertices + fresh > maxGroupVertices) break;
        for (int c = 0; c < 3; c++) {
          if (groupOf[own[c]] != attempt) {
            groupOf[own[c]] = attempt;
            localOf[own[c]] = uint8_t(vertices);
            corner[vertices++] = own[c];
          }
          local[used][c] = localOf[own[c]];
        }
      }
      count = used;
      strips.make(local, count, keepsOrder);
      if (strips.numRestarts <= maxGroupRestarts) break;
    }
    Group& group = all[groups++];
    group.triangles = count;
    group.restarts = strips.numRestarts;
    group.restartMask = strips.restarts;
    group.fanMask = strips.fans;
    group.firstVertex = numVertices;
    group.vertices = group.owned = group.repeats = 0;
    group.ownMask = 0;
    group.newMask = 0;
    uint8_t reached[maxGroupVertices + 1];
    std::memset(reached, 255, sizeof(reached));
    for (uint32_t i = 0; i < strips.streamSize; i++) {
      const uint8_t v = strips.stream[i];
      if (reached[v] != 255) {
        group.repeated[group.repeats++] = reached[v];
        continue;
      }
      reached[v] = uint8_t(group.vertices);
      group.newMask |= uint64_t(1) << i;
      uint16_t& number = numberOf[corner[v]];
      if (number == noNumber) {
        number = uint16_t(numVertices);
        cornerOfVertex[numVertices] = uint16_t(corner[v]);
        std::memcpy(vertices[numVertices++], corners[corner[v]], sizeof(vertices[0]));
        group.ownMask |= 1u << group.vertices;
        group.owned++;
      }
      group.numbers[group.vertices++] = number;
    }
    for (uint32_t t = 0; t < count; t++) {
      group.firstCorners[t] = strips.firstCorners[t];
      group.triangleNumbers[t] = triangles[strips.order[t]].number;
    }
    numTriangles += count;
  }

  /*! Chooses spacing or ranks on axis k, and computes the coordinates. */
  void chooseCoordinates(int k) {
    float lo = vertices[0][k], hi = lo;
    int step = 1000;
    for (uint32_t v = 0; v < numVertices; v++) {
      const float x = vertices[v][k];
      lo = std::min(lo, x);
      hi = std::max(hi, x);
      const uint32_t bits = bitsOfFloat(x), biased = (bits >> 23) & 255;
      const uint32_t mantissa = (bits & 0x7FFFFF) | (biased != 0 ? 0x800000u : 0u);
      if (mantissa != 0) step = std::min(step, int(std::max(biased, 1u)) - 150 + __builtin_ctz(mantissa));
    }
    origin[k] = lo;
    isRanked[k] = false;
    fitsLattice[k] = true;
    exponent[k] = std::max(step, -126);
    const double span = double(hi) - double(lo);
    if (span == 0) { // the smallest spacing makes boxes thin
      exponent[k] = -126;
      std::fill(coordinates[k], coordinates[k] + numVertices, 0u);
      return;
    }
    const bool fits = step >= -126 && std::ldexp(span, -step) < double(1 << maxMeshCoordinateBits);
    fitsLattice[k] = fits;
    if (fits) {
      useLattice(k);
      if (std::ldexp(span, -step) < double(1 << maxUnrankedBits)) return;
    }
    const uint32_t first = rankOfFloat(lo);
    for (uint32_t v = 0; v < numVertices; v++) other[v] = rankOfFloat(vertices[v][k]) - first;
    isRanked[k] = !fits || bitsOnAxis(other, true) < bitsOnAxis(coordinates[k], false);
    if (isRanked[k]) std::memcpy(coordinates[k], other, numVertices * sizeof(other[0]));
  }

  /*! Computes coordinates on axis k, in place of ranks. Requires fitsLattice. */
  void useLattice(int k) {
    const double unit = std::ldexp(1.0, -exponent[k]), least = double(origin[k]);
    for (uint32_t v = 0; v < numVertices; v++)
      coordinates[k][v] = uint32_t(int((double(vertices[v][k]) - least) * unit));
    isRanked[k] = false;
  }

  /*! Bits of all fields on an axis, or 2^64-1 if coordinates have too many. values: coordinates or ranks. */
  uint64_t bitsOnAxis(const uint32_t* values, bool ranked) const {
    uint32_t lo[maxMeshGroups], hi[maxMeshGroups], most = 0;
    for (uint32_t g = 0; g < groups; g++) {
      lo[g] = hi[g] = values[all[g].numbers[0]];
      for (uint32_t i = 1; i < all[g].vertices; i++) {
        const uint32_t c = values[all[g].numbers[i]];
        lo[g] = std::min(lo[g], c);
        hi[g] = std::max(hi[g], c);
      }
      most = std::max(most, hi[g]);
    }
    if (!ranked && most >= 1u << maxMeshCoordinateBits) return ~uint64_t(0);
    const uint32_t shift = shiftOf(most, ranked);
    uint64_t sum = 0;
    for (uint32_t g = 0; g < groups; g++)
      sum += all[g].owned * bitWidth((((hi[g] >> shift) - (lo[g] >> shift) + 1) << shift) - 1);
    return sum;
  }

  /*! Shift of boxes. most: largest coordinate. */
  static uint32_t shiftOf(uint32_t most, bool ranked) {
    const uint32_t bits = bitWidth(most), least = ranked ? minRankShift : 0;
    return bits > 8 + least ? bits - 8 : least;
  }

  static const int maxUnrankedBits = 18; //!< ranks are only tried if coordinates have more bits

  /*! Shears an axis if that shortens its fields. */
  void chooseShear() {
    shearedAxis = 0;
    slopes[0] = slopes[1] = 0;
    if (isRanked[0] || isRanked[1] || isRanked[2]) return;
    double mean[3] = {0, 0, 0}, s[3][3] = {};
    for (int k = 0; k < 3; k++) {
      for (uint32_t v = 0; v < numVertices; v++) mean[k] += coordinates[k][v];
      mean[k] /= numVertices;
    }
    for (uint32_t v = 0; v < numVertices; v++) {
      const double x = coordinates[0][v] - mean[0], y = coordinates[1][v] - mean[1], z = coordinates[2][v] - mean[2];
      s[0][0] += x * x;
      s[1][1] += y * y;
      s[2][2] += z * z;
      s[0][1] += x * y;
      s[1][2] += y * z;
      s[2][0] += z * x;
    }
    s[1][0] = s[0][1];
    s[2][1] = s[1][2];
    s[0][2] = s[2][0];
    // the axis on which a plane (least squares) explains most of the variance, and at least half
    double best = 0.5;
    for (int m = 0; m < 3; m++) {
      const int a = (m + 1) % 3, b = (m + 2) % 3;
      const double det = s[a][a] * s[b][b] - s[a][b] * s[a][b];
      if (!(det > 1e-9 * s[a][a] * s[b][b]) || !(s[m][m] > 0)) continue;
      const double p = (s[m][a] * s[b][b] - s[m][b] * s[a][b]) / det, q = (s[m][b] * s[a][a] - s[m][a] * s[a][b]) / det;
      const double rest = (s[m][m] - p * s[m][a] - q * s[m][b]) / s[m][m];
      if (!(std::fabs(p) < 15.5 / 16 && std::fabs(q) < 15.5 / 16 && rest < best)) continue;
      best = rest;
      shearedAxis = uint32_t(m);
      slopes[0] = int(std::floor(-16 * p + 0.5));
      slopes[1] = int(std::floor(-16 * q + 0.5));
    }
    if ((slopes[0] | slopes[1]) == 0) return;
    const uint32_t *const c1 = coordinates[(shearedAxis + 1) % 3], *const c2 = coordinates[(shearedAxis + 2) % 3];
    uint32_t* const c = coordinates[shearedAxis];
    int least = 0x7FFFFFFF; // of the sheared coordinates
    int largest = 0;        // of the unsheared ones
    for (uint32_t v = 0; v < numVertices; v++) {
      const int sheared = int(c[v]) + ((slopes[0] * int(c1[v]) + slopes[1] * int(c2[v]) + 8) >> 4);
      other[v] = uint32_t(sheared);
      least = std::min(least, sheared);
      largest = std::max(largest, int(c[v]));
    }
    // sheared coordinates begin at 0
    for (uint32_t v = 0; v < numVertices; v++) other[v] -= uint32_t(least);
    const double moved = double(origin[shearedAxis]) + std::ldexp(double(least), exponent[shearedAxis]);
    // coordinates relative to the moved origin, and the origin itself, must be exact in float
    if (bitsOnAxis(other, false) >= bitsOnAxis(c, false) || largest - least > 1 << 24 ||
        double(float(moved)) != moved) {
      slopes[0] = slopes[1] = 0;
      return;
    }
    origin[shearedAxis] = float(moved);
    std::memcpy(c, other, numVertices * sizeof(other[0]));
  }

  /*! Computes the boxes of groups in units of 2^shift. */
  void computeBounds() {
    for (int k = 0; k < 3; k++) {
      const uint32_t* const onAxis = coordinates[k];
      uint32_t most = 0;
      for (uint32_t v = 0; v < numVertices; v++) most = std::max(most, onAxis[v]);
      shifts[k] = shiftOf(most, isRanked[k]);
      for (uint32_t g = 0; g < groups; g++) {
        Group& group = all[g];
        uint32_t lo = ~0u, hi = 0;
        for (uint32_t i = 0; i < group.vertices; i++) {
          const uint32_t c = onAxis[group.numbers[i]];
          lo = std::min(lo, c);
          hi = std::max(hi, c);
        }
        group.lower[k] = lo >> shifts[k];
        group.extent[k] = (hi >> shifts[k]) - group.lower[k];
      }
    }
  }

  size_t write(uint32_t surface, uint8_t* block, MeshStatistics& statistics) {
    const Numbers numbers = findNumbers();
    MeshHeader header = makeHeader(surface, numbers);
    const MeshLayout layout = meshLayout(header.counts);
    for (uint32_t g = 0; g < groups; g++) writeRecord(all[g], g, numbers.bits[g], layout, header, block);
    BitWriter topology(block + layout.topology);
    for (uint32_t g = 0; g < groups; g++) writeTopology(all[g], topology);
    BitWriter fields(topology.finish());
    for (uint32_t g = 0; g < groups; g++) statistics.vertexBits += writeFields(all[g], header, fields);
    BitWriter triangles(fields.finish());
    for (uint32_t g = 0; g < groups; g++) statistics.numberBits += writeNumbers(all[g], g, numbers, triangles);
    uint8_t* end = triangles.finish();
    while ((end - block) % 4 != 0) *end++ = 0;
    header.bytes = uint32_t(end - block);
    std::memcpy(block, &header, sizeof(header));
    addTo(statistics, header, layout, block);
    return header.bytes;
  }

  /*! Numbers of triangles: the block's lowest one, and how groups store theirs relative to it. */
  struct Numbers {
    uint32_t lowest, baseBits;
    uint32_t base[maxMeshGroups], bits[maxMeshGroups];
  };

  Numbers findNumbers() const {
    Numbers numbers;
    uint32_t highestBase = 0;
    numbers.lowest = ~0u;
    for (uint32_t g = 0; g < groups; g++) {
      const uint32_t* const ids = all[g].triangleNumbers;
      const uint32_t base = *std::min_element(ids, ids + all[g].triangles);
      numbers.base[g] = base;
      numbers.bits[g] = bitWidth(*std::max_element(ids, ids + all[g].triangles) - base);
      if (numbers.bits[g] == 31) numbers.bits[g] = 32;
      numbers.lowest = std::min(numbers.lowest, base);
      highestBase = std::max(highestBase, base);
    }
    numbers.baseBits = bitWidth(highestBase - numbers.lowest);
    return numbers;
  }

  /*! Without the block's size, and what writeRecord() adds. */
  MeshHeader makeHeader(uint32_t surface, const Numbers& numbers) const {
    MeshHeader header;
    std::memset(&header, 0, sizeof(header));
    std::memcpy(header.origin, origin, sizeof(origin));
    for (int k = 0; k < 3; k++) header.spacings |= (isRanked[k] ? 0u : uint32_t(exponent[k] + 127)) << (8 * k);
    for (int k = 0; k < 3; k++) header.info |= (shifts[k] - (isRanked[k] ? minRankShift : 0)) << (4 * k);
    header.surface = surface;
    header.primID = numbers.lowest;
    header.counts =
        meshTagOfCounts() | (numVertices - 1) | (groups - 1) << 10 | (numTriangles - 1) << 16 | numbers.baseBits << 24;
    header.info |=
        meshTagOfInfo() | shearedAxis << 12 | (uint32_t(slopes[0]) & 31) << 16 | (uint32_t(slopes[1]) & 31) << 21;
    return header;
  }

  /*! Writes the sizes and the box of a group. numberBits: see Numbers. */
  void writeRecord(const Group& group, uint32_t g, uint32_t numberBits, const MeshLayout& layout, MeshHeader& header,
                   uint8_t* block) const {
    const uint32_t byte = (group.triangles - 1) | (group.restarts & 7) << 5;
    const uint32_t record =
        group.vertices | group.owned << 5 | std::min(numberBits, 31u) << 10 | (group.restarts >> 3) << 15;
    header.groups[g / 4] |= byte << (8 * (g % 4));
    block[layout.records + 2 * g] = uint8_t(record);
    block[layout.records + 2 * g + 1] = uint8_t(record >> 8);
    for (int k = 0; k < 3; k++) {
      block[layout.boxes + uint32_t(k) * groups + g] = uint8_t(group.lower[k]);
      block[layout.boxes + uint32_t(3 + k) * groups + g] = uint8_t(group.extent[k]);
    }
  }

  /*! Writes the strips of a group, and which of its vertices it owns. */
  void writeTopology(const Group& group, BitWriter& topology) const {
    const uint32_t stream = streamLength(group.triangles, group.restarts), repeatBits = bitWidth(group.vertices - 1),
                   otherBits = bitWidth(numVertices - 1);
    topology.write(group.restartMask >> 1, group.triangles - 1);
    topology.write(group.fanMask >> 1, group.triangles - 1);
    for (uint32_t t = 0; t < group.triangles; t++) topology.write(group.firstCorners[t], 2);
    const uint64_t mask = group.newMask >> 3;
    topology.write(uint32_t(mask), std::min(stream - 3, 32u));
    if (stream - 3 > 32) topology.write(uint32_t(mask >> 32), stream - 3 - 32);
    topology.write(group.ownMask, group.vertices);
    for (uint32_t i = 0; i < group.repeats; i++) topology.write(group.repeated[i], repeatBits);
    for (uint32_t i = 0; i < group.vertices; i++)
      if (((group.ownMask >> i) & 1) == 0) topology.write(group.numbers[i], otherBits);
  }

  /*! Writes the coordinates of the vertices that a group owns, relative to its box. Returns the number of bits. */
  uint32_t writeFields(const Group& group, const MeshHeader& header, BitWriter& fields) const {
    uint32_t bits[3];
    for (uint32_t k = 0; k < 3; k++) bits[k] = meshFieldBits(header.spacings, header.info, group.extent[k], k);
    for (uint32_t v = group.firstVertex; v < group.firstVertex + group.owned; v++)
      for (int k = 0; k < 3; k++) fields.write(coordinates[k][v] - (group.lower[k] << shifts[k]), bits[k]);
    return group.owned * (bits[0] + bits[1] + bits[2]);
  }

  /*! Writes the numbers of a group's triangles. Returns the number of bits. */
  static uint32_t writeNumbers(const Group& group, uint32_t g, const Numbers& numbers, BitWriter& triangles) {
    triangles.write(numbers.base[g] - numbers.lowest, numbers.baseBits);
    for (uint32_t t = 0; t < group.triangles; t++)
      triangles.write(group.triangleNumbers[t] - numbers.base[g], numbers.bits[g]);
    return numbers.baseBits + group.triangles * numbers.bits[g];
  }

  /*! Counts a written block, but not the bits of vertices and numbers. */
  void addTo(MeshStatistics& statistics, const MeshHeader& header, const MeshLayout& layout,
             const uint8_t* block) const {
    for (uint32_t g = 0; g < groups; g++) {
      const uint32_t byte = header.groups[g / 4] >> (8 * (g % 4)) & 255u,
                     record = block[layout.records + 2 * g] | uint32_t(block[layout.records + 2 * g + 1]) << 8;
      statistics.topologyBits += meshTopology(byte, record, numVertices).bits;
      statistics.restarts += all[g].restarts;
    }
    statistics.blocks++;
    statistics.groups += groups;
    statistics.triangles += numTriangles;
    statistics.vertices += numVertices;
    statistics.bytes += header.bytes;
    for (bool is : isRanked) statistics.rankAxes += is;
    statistics.shearedBlocks += (slopes[0] | slopes[1]) != 0;
  }

  /*! Empty unless its epoch is the current one, so that blocks need not clear the table. */
  struct Slot {
    uint32_t epoch, corner;
  };
  Slot slots[slotCount];
  uint32_t epoch = 0, attempt = 0;
  /* Corners of the block's triangles, in the order of insertion. A corner becomes a vertex when a group uses it. */
  uint32_t numCorners;
  float corners[3 * maxMeshTriangles + 3 * maxGroupTriangles][3];
  uint16_t numberOf[3 * maxMeshTriangles + 3 * maxGroupTriangles]; //!< number of each corner as a vertex of the block
  uint32_t groupOf[3 * maxMeshTriangles + 3 * maxGroupTriangles];  //!< last attempt to add a group with the corner
  uint8_t localOf[3 * maxMeshTriangles + 3 * maxGroupTriangles];   //!< its index in that attempt
  /*! IDs of corners of triangles from idsBegin on; null if positions identify vertices. */
  const uint32_t (*ids)[3] = nullptr;
  const MeshTriangle* idsBegin = nullptr;
  uint32_t idOfCorner[3 * maxMeshTriangles + 3 * maxGroupTriangles];
  uint16_t cornerOfVertex[maxMeshVertices];
  MeshStrips strips;
  bool keepsOrder = false; //!< see encodeInOrder
  uint32_t groups, numTriangles, numVertices;
  Group all[maxMeshGroups];
  float vertices[maxMeshVertices][3];
  uint32_t coordinates[3][maxMeshVertices], other[maxMeshVertices];
  float origin[3];
  int exponent[3];
  bool isRanked[3], fitsLattice[3]; //!< fitsLattice: ranks are not necessary
  uint32_t shearedAxis, shifts[3];
  int slopes[2];
};
}} // namespace cvert::CVERT_ISA
