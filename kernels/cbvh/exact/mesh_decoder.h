// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD decoder of mesh blocks (cvert/format/mesh_block.h): first the data that groups share, then half a group at a
 * time. cvert/decoder/decoded_mesh.h is the scalar reference. Reads less than vertReadPadding bytes after the block.
 *
 * docs/formats/mesh.md defines restarts, fans, firstCorners, newMask, ownMask, repeats and otherIndices. */

#include "../base/codec_names.h"
#include "../base/vectors.h"
#include "../../cvert/format/mesh_block.h"
#include "mesh_cache.h"
#include <cmath>

namespace embree::isa::cbvh {
using namespace embree::cbvh;

class MeshDecoder {
public:
  __forceinline explicit MeshDecoder(const MeshHeader* block) : block(block) {}

  /*! Decodes a block's entry, except for out.block. */
  __forceinline void decode(MeshBlockEntry& out) const {
    const uint32_t groups = meshGroups(block->counts);
    out.lanes = (1u << groups) - 1;
    setAxes(out);
    decodeBoxes(groups, out);
    decodeGroupOffsets(groups, out);
  }

  /*! Decodes half of group g. entry: output of decode(). Does not set out.key. */
  __forceinline void triangles(const MeshBlockEntry& entry, uint32_t g, uint32_t half, MeshTriangles& out) const {
    const uint32_t group = meshGroupByte(block, g), record = meshRecord(block, g), count = groupTriangles(group),
                   vertexCount = groupVertices(record), stream = streamLength(count, groupRestarts(group, record)),
                   repeatBits = bitsFor(vertexCount);
    const uint32_t lanes = 0xFFFFFFFFu >> (32 - count);
    out.lanes = uint16_t(half ? lanes >> 16 : lanes);
    out.hasNextHalf = half == 0 && count > 16;
    out.numVertices = uint8_t(vertexCount);
    BitReader at(block, entry.topologyBegin + entry.topology[g]);
    const uint32_t restarts = at.read(count - 1) << 1, fans = at.read(count - 1) << 1;
    uint64_t firstCorners = at.read(min(2 * count, 32u));
    if (unlikely(count > 16)) firstCorners |= uint64_t(at.read(2 * count - 32)) << 32;
    uint64_t newMask = at.read(min(stream - 3, 32u));
    if (unlikely(stream - 3 > 32)) newMask |= uint64_t(at.read(stream - 3 - 32)) << 32;
    const uint32_t ownMask = at.read(vertexCount);
    BitReader repeats = at;
    at.skip((stream - vertexCount) * repeatBits);
    decodeVertices(entry, g, vertexCount, ownMask, at, out.vertices);
#if defined(__AVX2__)
    if (likely(count <= 16 && stream <= 32 && stream - vertexCount <= 8)) {
      decodeStripsInParallel(restarts | 1, fans, uint32_t(firstCorners), uint32_t(newMask) << 3 | 7, repeats.peek(),
                             repeatBits, out.corners);
      return;
    }
#endif
    decodeStripsSerially(count, 16 * half, restarts, fans, firstCorners, newMask, repeats, repeatBits, out.corners);
  }

  /*! Number of a triangle of group g, for primitiveOfMesh. index: of the triangle in the group, 0 to 31. */
  __forceinline uint32_t number(const MeshBlockEntry& entry, uint32_t g, uint32_t index) const {
    const uint32_t baseBits = baseNumberBits(block->counts), bits = groupNumberBits(meshRecord(block, g));
    BitReader at(block, entry.numbersBegin + entry.numbers[g]);
    const uint32_t base = at.read(baseBits);
    at.skip(index * bits);
    return block->primID + base + at.read(bits);
  }

protected:
  /*! Reads a block's bits, from `bit` on. */
  struct BitReader {
    const uint8_t* data;
    uint32_t bit;

    __forceinline BitReader(const MeshHeader* block, uint32_t bit) : data((const uint8_t*)block), bit(bit) {}

    /*! The next 57 bits; higher ones are undefined. */
    __forceinline uint64_t peek() const {
      uint64_t word;
      memcpy(&word, data + (bit >> 3), sizeof(word));
      return word >> (bit & 7);
    }
    __forceinline void skip(uint32_t count) { bit += count; }
    /*! Reads `count` bits, 0 to 32. */
    __forceinline uint32_t read(uint32_t count) {
      const uint32_t value = uint32_t(peek() & ((uint64_t(1) << count) - 1));
      bit += count;
      return value;
    }
  };

  /*! The last triangle of a strip, as vertices of the group. isFlipped: its orientation is the reverse of
   *  (a,b,c). */
  struct Strip {
    uint32_t a = 0, b = 1, c = 2;
    bool isFlipped = false;

    /*! Adds the triangle (a,c,vertex) of a fan, otherwise (b,c,vertex). */
    void add(uint32_t vertex, bool isFan) {
      if (!isFan) a = b;
      b = c;
      c = vertex;
      isFlipped ^= !isFan;
    }

    /*! Corners in the application's order, 8 bits each. firstCorner: first corner, 0 to 2. */
    uint32_t corners(uint32_t firstCorner) const {
      const uint64_t v = (isFlipped ? b | a << 8 : a | b << 8) | c << 16;
      return uint32_t((v | v << 24) >> (8 * firstCorner));
    }
  };

  /*! Decodes triangles `first` to first+15 of a group. count: triangles of the group. restarts, fans: masks of
   *  triangles that start a strip or continue a fan; bit 0 must be clear. firstCorners: two bits per triangle.
   *  newMask: entries of the stream that are new vertices, without the first three entries, which are always
   *  new. repeats: indices of the vertices of other entries. */
  static void decodeStripsSerially(uint32_t count, uint32_t first, uint32_t restarts, uint32_t fans,
                                   uint64_t firstCorners, uint64_t newMask, BitReader repeats, uint32_t repeatBits,
                                   uint8_t (*corners)[16]) {
    memset(corners, 0, sizeof(corners[0]) * 3);
    Strip strip;
    uint32_t numNew = 3;
    auto next = [&]() {
      const bool isNew = newMask & 1;
      newMask >>= 1;
      return isNew ? numNew++ : repeats.read(repeatBits);
    };
    for (uint32_t t = 0; t < count; t++, firstCorners >>= 2) {
      if ((restarts >> t) & 1) {
        strip.a = next();
        strip.b = next();
        strip.c = next();
        strip.isFlipped = false;
      } else if (t > 0) strip.add(next(), (fans >> t) & 1);
      if (t < first || t - first >= 16) continue;
      const uint32_t v = strip.corners(uint32_t(firstCorners) & 3);
      for (int c = 0; c < 3; c++) corners[c][t - first] = uint8_t(v >> (8 * c)) & 31u; // 31: for damaged blocks
    }
  }

#if defined(__AVX2__)
  /*! Expands bits to bytes of ones or zeros. */
  static __forceinline __m128i bytesOfBits(uint32_t bits) {
    const __m128i bitOfLane = _mm_setr_epi8(1, 2, 4, 8, 16, 32, 64, -128, 1, 2, 4, 8, 16, 32, 64, -128);
    const __m128i byteOfLane = _mm_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
    const __m128i spread = _mm_shuffle_epi8(_mm_set1_epi16(short(bits)), byteOfLane);
    return _mm_cmpeq_epi8(_mm_and_si128(spread, bitOfLane), bitOfLane);
  }

  /*! Inclusive prefix sums of bytes. */
  static __forceinline __m128i prefixSumsOfBytes(__m128i x) {
    x = _mm_add_epi8(x, _mm_slli_si128(x, 1));
    x = _mm_add_epi8(x, _mm_slli_si128(x, 2));
    x = _mm_add_epi8(x, _mm_slli_si128(x, 4));
    return _mm_add_epi8(x, _mm_slli_si128(x, 8));
  }

  /*! Inclusive prefix maxima of bytes. */
  static __forceinline __m128i prefixMaximaOfBytes(__m128i x) {
    x = _mm_max_epu8(x, _mm_slli_si128(x, 1));
    x = _mm_max_epu8(x, _mm_slli_si128(x, 2));
    x = _mm_max_epu8(x, _mm_slli_si128(x, 4));
    return _mm_max_epu8(x, _mm_slli_si128(x, 8));
  }

  /*! decodeStripsSerially for up to 16 triangles, one per byte, whose stream has up to 32 entries, up to 8 of
   *  them not new. Bit 0 of `restarts` must be set. newMask: of all entries. */
  static __forceinline void decodeStripsInParallel(uint32_t restarts, uint32_t fans, uint32_t firstCorners,
                                                   uint32_t newMask, uint64_t repeats, uint32_t repeatBits,
                                                   uint8_t (*corners)[16]) {
    const __m128i one = _mm_set1_epi8(1), lanes = _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);

    // repeated: the eight fields of `repeats`, one byte each
    const __m256i fields = _mm256_set1_epi64x((long long)repeats), fieldBits = _mm256_set1_epi64x(repeatBits);
    const __m256i shifts = _mm256_mul_epu32(fieldBits, _mm256_setr_epi64x(0, 1, 2, 3));
    const __m256i fields0To3 = _mm256_srlv_epi64(fields, shifts),
                  fields4To7 = _mm256_srlv_epi64(fields, _mm256_add_epi64(shifts, _mm256_slli_epi64(fieldBits, 2)));
    const __m256i mask = _mm256_set1_epi32((1 << repeatBits) - 1);
    const __m256i pairs =
        _mm256_and_si256(_mm256_blend_epi32(fields0To3, _mm256_slli_epi64(fields4To7, 32), 0xAA), mask);
    const __m256i packed =
        _mm256_shuffle_epi8(pairs, _mm256_setr_epi8(0, 8, -1, -1, 4, 12, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1,
                                                    0, 8, -1, -1, 4, 12, -1, -1, -1, -1, -1, -1, -1, -1));
    const __m128i repeated = _mm_or_si128(_mm256_castsi256_si128(packed), _mm256_extracti128_si256(packed, 1));

    __m128i entries[2];                   // vertices of the stream's entries
    __m128i before = _mm_setzero_si128(); // number of new entries in the first half
    for (int half = 0; half < 2; half++) {
      const __m128i isNew = bytesOfBits(newMask >> (16 * half)), isOne = _mm_and_si128(isNew, one);
      // numbers of new and of repeated entries before each entry
      const __m128i newBefore = _mm_add_epi8(before, _mm_sub_epi8(prefixSumsOfBytes(isOne), isOne));
      const __m128i repeatedBefore = _mm_sub_epi8(_mm_add_epi8(lanes, _mm_set1_epi8(char(16 * half))), newBefore);
      entries[half] = _mm_blendv_epi8(_mm_shuffle_epi8(repeated, repeatedBefore), newBefore, isNew);
      before = _mm_set1_epi8(char(__builtin_popcount(newMask & 0xFFFF)));
    }
    auto entryAt = [&](__m128i index) {
      return _mm_blendv_epi8(_mm_shuffle_epi8(entries[0], index), _mm_shuffle_epi8(entries[1], index),
                             _mm_cmpgt_epi8(index, _mm_set1_epi8(15)));
    };

    /* A restart has three entries instead of one. first, last: indices of the entries of a triangle's first and
     * last vertex. A fan keeps the first one. */
    const __m128i starts = bytesOfBits(restarts), isFan = bytesOfBits(fans);
    const __m128i last = _mm_add_epi8(lanes, prefixSumsOfBytes(_mm_and_si128(starts, _mm_set1_epi8(2))));
    const __m128i first = prefixMaximaOfBytes(_mm_andnot_si128(isFan, _mm_sub_epi8(last, _mm_set1_epi8(2))));
    // triangles that neither continue a fan nor start a strip reverse the orientation of the one before
    const __m128i flips = prefixSumsOfBytes(_mm_andnot_si128(_mm_or_si128(isFan, starts), one));
    const __m128i flipsSinceStart = _mm_sub_epi8(flips, prefixMaximaOfBytes(_mm_and_si128(starts, flips)));
    const __m128i isFlipped = _mm_cmpeq_epi8(_mm_and_si128(flipsSinceStart, one), one);
    const __m128i a = entryAt(first), b = entryAt(_mm_sub_epi8(last, one)), c = entryAt(last);
    const __m128i p = _mm_blendv_epi8(a, b, isFlipped), q = _mm_blendv_epi8(b, a, isFlipped);

    // two bits of `firstCorners` per triangle
    const __m128i byteOfLane = _mm_setr_epi8(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    const __m128i spread = _mm_shuffle_epi8(_mm_set1_epi32(int(firstCorners)), byteOfLane);
    const __m128i low = _mm_setr_epi8(1, 4, 16, 64, 1, 4, 16, 64, 1, 4, 16, 64, 1, 4, 16, 64),
                  high = _mm_add_epi8(low, low);
    const __m128i is1 = _mm_cmpeq_epi8(_mm_and_si128(spread, low), low),
                  is2 = _mm_cmpeq_epi8(_mm_and_si128(spread, high), high);
    auto rotate = [&](__m128i x, __m128i y, __m128i z) { // 31: keeps corners below 32 in damaged blocks
      return _mm_and_si128(_mm_blendv_epi8(_mm_blendv_epi8(x, y, is1), z, is2), _mm_set1_epi8(31));
    };
    _mm_store_si128((__m128i*)corners[0], rotate(p, q, c));
    _mm_store_si128((__m128i*)corners[1], rotate(q, c, p));
    _mm_store_si128((__m128i*)corners[2], rotate(c, p, q));
  }
#endif

  /*! bitsForIndex() of the codec, without its loop. */
  static __forceinline uint32_t bitsFor(uint32_t count) {
    return count < 2 ? 0 : 32 - uint32_t(__builtin_clz(count - 1));
  }

  /*! True if a slope of the shear is not 0. */
  __forceinline bool isSheared() const { return (block->info & 0x03FF0000u) != 0; }

  /*! Sets the axes of boxes in world space. The shear is 1 on the sheared axis, and slope times ratio of spacings
   *  on the others. If a ratio or its inverse exceeds 2^maxRatioExponent, no axis is sheared, and boxes are
   *  unlimited on the axis that the block shears. */
  __forceinline void setAxes(MeshBlockEntry& out) const {
    out.shearedAxis = 3;
    for (int k = 0; k < 3; k++) {
      out.origin[k] = block->origin[k];
      out.shear[k] = 0.0f;
    }
    if (likely(!isSheared())) return;
    const int m = int(meshShearedAxis(block->info));
    for (int i = 1; i < 3; i++)
      if (ratioExponent(m, i) < -maxRatioExponent || ratioExponent(m, i) > maxRatioExponent) return;
    out.shearedAxis = m;
    out.shear[m] = 1.0f;
    for (int i = 1; i < 3; i++)
      out.shear[axisAfter(m, i)] = float(meshSlope(block->info, uint32_t(i))) * (1.0f / 16.0f) *
                                   floatOfBits(uint32_t(ratioExponent(m, i) + 127) << 23);
  }

  static const int maxRatioExponent = 30;

  /*! Exponent of the ratio of the spacings on axis m and on the i-th axis after it. */
  __forceinline int ratioExponent(int m, int i) const {
    auto exponent = [&](int k) { return int((block->spacings >> (8 * k)) & 255); };
    return exponent(m) - exponent(axisAfter(m, i));
  }

  /*! Sets planes, lower coordinates and extents. */
  __forceinline void decodeBoxes(uint32_t groups, MeshBlockEntry& out) const {
    const uint8_t* const bytes = (const uint8_t*)block + meshLayout(block->counts).boxes;
    float maxCoordinate[3];
    for (int k = 0; k < 3; k++) {
      const uint32_t shift = meshBoxShift(block->spacings, block->info, uint32_t(k));
      if (unlikely(hasRanks(block->spacings, uint32_t(k)))) {
        decodeRankedBoxes(k, bytes, groups, shift, out);
        maxCoordinate[k] = 0.0f;
        continue;
      }
      const bool sheared = isSheared() && uint32_t(k) == meshShearedAxis(block->info);
      const vfloatV spacing(meshSpacing(block->spacings, uint32_t(k))), origin(sheared ? 0.0f : block->origin[k]),
          rounding(sheared ? 0.5f : 0.0f);
      for (int n = 0; n < 16; n += vectorWidth) {
        const vintV lower = loadBytes(bytes + uint32_t(k) * groups + n) << int(shift),
                    upper = lower + ((loadBytes(bytes + uint32_t(3 + k) * groups + n) + vintV(1)) << int(shift));
        vintV::storeu(&out.lower[k][n], lower);
        const vfloatV begin(lower), end(upper);
        vfloatV::store(out.planes[k].at[0] + n, origin + (begin - rounding) * spacing);
        vfloatV::store(out.planes[k].at[1] + n, origin + end * spacing);
      }
      maxCoordinate[k] = float(256u << shift); // bytes of plane and extent, plus 1, are at most 256
      out.extent[k] = maxCoordinate[k] * meshSpacing(block->spacings, uint32_t(k));
    }
    if (likely(!isSheared())) return;
    const int m = int(meshShearedAxis(block->info));
    for (int i = 1; i < 3; i++)
      maxCoordinate[m] +=
          std::fabs(float(meshSlope(block->info, uint32_t(i)))) * (1.0f / 16.0f) * maxCoordinate[axisAfter(m, i)];
    out.extent[m] = (maxCoordinate[m] + 1.0f) * meshSpacing(block->spacings, uint32_t(m));
    if (unlikely(out.shearedAxis == 3))
      for (int l = 0; l < 16; l++) {
        out.planes[m].at[0][l] = -1e30f;
        out.planes[m].at[1][l] = 1e30f;
      }
  }

  /*! decodeBoxes on an axis of ranks (hasRanks). */
  void decodeRankedBoxes(int k, const uint8_t* bytes, uint32_t groups, uint32_t shift, MeshBlockEntry& out) const {
    const uint32_t origin = rankOfFloat(block->origin[k]);
    out.extent[k] = 0.0f;
    for (uint32_t l = 0; l < 16; l++) {
      const uint32_t g = min(l, groups - 1), lower = uint32_t(bytes[uint32_t(k) * groups + g]) << shift;
      out.lower[k][l] = lower;
      out.planes[k].at[0][l] = floatOfRank(origin + lower);
      out.planes[k].at[1][l] = floatOfRank(origin + lower + ((bytes[uint32_t(3 + k) * groups + g] + 1u) << shift) - 1u);
      out.extent[k] = max(out.extent[k], out.planes[k].at[1][l] - block->origin[k]);
    }
  }

  /*! Bit lengths of bytes: 0 for 0, 8 for 128 to 255. */
  static __forceinline __m128i bitLengthsOf(__m128i bytes) {
#if defined(__SSSE3__)
    const __m128i nibble = _mm_set1_epi8(15);
    const __m128i lengthsOfLow = _mm_setr_epi8(0, 1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4),
                  lengthsOfHigh = _mm_setr_epi8(0, 5, 6, 6, 7, 7, 7, 7, 8, 8, 8, 8, 8, 8, 8, 8);
    return _mm_max_epu8(_mm_shuffle_epi8(lengthsOfLow, _mm_and_si128(bytes, nibble)),
                        _mm_shuffle_epi8(lengthsOfHigh, _mm_and_si128(_mm_srli_epi16(bytes, 4), nibble)));
#else
    __m128i lengths = _mm_setzero_si128();
    for (int bit = 0; bit < 8; bit++) // x has more than `bit` bits if x >= 2^bit
      lengths = _mm_sub_epi8(lengths, _mm_cmpeq_epi8(_mm_max_epu8(bytes, _mm_set1_epi8(char(1 << bit))), bytes));
    return lengths;
#endif
  }

  /*! Stores exclusive prefix sums of 16 numbers. Returns the total. */
  static __forceinline uint32_t storePrefixSums(const __m128i numbers[2], uint16_t out[16]) {
    uint32_t before = 0;
    for (int half = 0; half < 2; half++) {
      __m128i sum = _mm_add_epi16(numbers[half], _mm_slli_si128(numbers[half], 2));
      sum = _mm_add_epi16(sum, _mm_slli_si128(sum, 4));
      sum = _mm_add_epi16(sum, _mm_slli_si128(sum, 8));
      _mm_store_si128((__m128i*)(out + 8 * half),
                      _mm_add_epi16(_mm_sub_epi16(sum, numbers[half]), _mm_set1_epi16(short(before))));
      before += uint32_t(_mm_extract_epi16(sum, 7)) & 0xFFFF;
    }
    return before;
  }

  /*! Sets where the data of each group begin, as MeshView (cvert/decoder/mesh_view.h). All sums are less than
   *  2^16. */
  __forceinline void decodeGroupOffsets(uint32_t groups, MeshBlockEntry& out) const {
    const uint8_t* const bytes = (const uint8_t*)block;
    const MeshLayout layout = meshLayout(block->counts);
    const __m128i none = _mm_setzero_si128(), group = _mm_loadu_si128((const __m128i*)block->groups);

    // a field has the bits of the extent and of the shift
    __m128i bits[3], bitsPerVertex = none;
    for (uint32_t k = 0; k < 3; k++) {
      const __m128i extents = _mm_loadu_si128((const __m128i*)(bytes + layout.boxes + (3 + k) * groups));
      bits[k] = _mm_add_epi8(bitLengthsOf(extents), _mm_set1_epi8(char(meshBoxShift(block->spacings, block->info, k))));
      bitsPerVertex = _mm_add_epi8(bitsPerVertex, bits[k]);
    }
    for (int k = 0; k < 3; k++) _mm_store_si128((__m128i*)out.fieldBits[k], bits[k]);
    _mm_store_si128((__m128i*)out.fieldBits[3], bitsPerVertex);

    const uint8_t* const records = bytes + layout.records;
    const __m128i record[2] = {_mm_loadu_si128((const __m128i*)records),
                               groups > 8 ? _mm_loadu_si128((const __m128i*)(records + 16))
                                          : none}; // a short block can end there
    const __m128i fiveBits = _mm_set1_epi16(31);
    __m128i vertexCount[2], topology[2], vertices[2], numbers[2], own[2];
    for (int half = 0; half < 2; half++) vertexCount[half] = _mm_and_si128(record[half], fiveBits);
    const __m128i repeats =
        bitLengthsOf(_mm_sub_epi8(_mm_packus_epi16(vertexCount[0], vertexCount[1]), _mm_set1_epi8(1)));
    const __m128i otherBits = _mm_set1_epi16(short(bitsFor(meshVertices(block->counts)))),
                  baseBits = _mm_set1_epi16(short(baseNumberBits(block->counts)));
    for (int half = 0; half < 2; half++) {
      auto toWords = [&](__m128i x) { return half ? _mm_unpackhi_epi8(x, none) : _mm_unpacklo_epi8(x, none); };
      const __m128i lane = _mm_add_epi16(_mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7), _mm_set1_epi16(short(8 * half))),
                    isPresent = _mm_cmpgt_epi16(_mm_set1_epi16(short(groups)), lane);
      const __m128i sizes = toWords(group), r = record[half],
                    restarts =
                        _mm_or_si128(_mm_srli_epi16(sizes, 5), _mm_and_si128(_mm_srli_epi16(r, 12), _mm_set1_epi16(8))),
                    count = _mm_add_epi16(_mm_and_si128(sizes, fiveBits), _mm_set1_epi16(1)),
                    streamMinus2 = _mm_add_epi16(count, _mm_add_epi16(restarts, restarts));
      own[half] = _mm_and_si128(_mm_and_si128(_mm_srli_epi16(r, 5), fiveBits), isPresent);
      __m128i numberBits = _mm_and_si128(_mm_srli_epi16(r, 10), fiveBits);
      // 31 means 32, see groupNumberBits
      numberBits = _mm_sub_epi16(numberBits, _mm_cmpeq_epi16(numberBits, fiveBits));
      // restarts, fans, firstCorners, newMask, ownMask; then repeats, and indices of other groups' vertices
      __m128i sum = _mm_add_epi16(_mm_slli_epi16(count, 2), _mm_add_epi16(streamMinus2, vertexCount[half]));
      sum = _mm_sub_epi16(sum, _mm_set1_epi16(3));
      sum = _mm_add_epi16(
          sum, _mm_mullo_epi16(toWords(repeats),
                               _mm_sub_epi16(_mm_add_epi16(streamMinus2, _mm_set1_epi16(2)), vertexCount[half])));
      sum = _mm_add_epi16(sum, _mm_mullo_epi16(otherBits, _mm_sub_epi16(vertexCount[half], own[half])));
      topology[half] = _mm_and_si128(sum, isPresent);
      vertices[half] = _mm_mullo_epi16(own[half], toWords(bitsPerVertex));
      numbers[half] = _mm_and_si128(_mm_add_epi16(baseBits, _mm_mullo_epi16(count, numberBits)), isPresent);
    }
    out.topologyBegin = 8 * layout.topology;
    out.verticesBegin = out.topologyBegin + ((storePrefixSums(topology, out.topology) + 7) & ~7u);
    out.numbersBegin = out.verticesBegin + ((storePrefixSums(vertices, out.fieldBitOfVertex0) + 7) & ~7u);
    storePrefixSums(numbers, out.numbers);
    storePrefixSums(own, out.firstVertex);
    for (int half = 0; half < 2; half++) {
      __m128i* const zero = (__m128i*)out.fieldBitOfVertex0 + half;
      const __m128i first = _mm_load_si128((const __m128i*)out.firstVertex + half),
                    size = half ? _mm_unpackhi_epi8(bitsPerVertex, none) : _mm_unpacklo_epi8(bitsPerVertex, none);
      _mm_store_si128(zero, _mm_sub_epi16(_mm_load_si128(zero), _mm_mullo_epi16(first, size)));
    }
    for (uint32_t g = groups; g < 16; g++) out.firstVertex[g] = 0x7FFF;
  }

  /*! Group to which vertex v of the block belongs: the last that does not begin after it. */
  static __forceinline uint32_t groupOfVertex(const MeshBlockEntry& entry, uint32_t v) {
    const __m128i vertex = _mm_set1_epi16(short(v)), *const first = (const __m128i*)entry.firstVertex;
    const __m128i after = _mm_packs_epi16(_mm_cmpgt_epi16(_mm_load_si128(first), vertex),
                                          _mm_cmpgt_epi16(_mm_load_si128(first + 1), vertex));
    return uint32_t(__builtin_ctz(uint32_t(_mm_movemask_epi8(after)) | 0x10000u)) - 1;
  }

  /*! Reads the coordinates of a vertex that belongs to group g. bit: first bit of its fields. i: output lane. */
  __forceinline void readVertex(const MeshBlockEntry& entry, uint32_t g, uint32_t bit, uint32_t (*coordinates)[32],
                                uint32_t i) const {
    BitReader at(block, bit);
    if (unlikely(entry.fieldBits[3][g] > 57)) {
      for (int k = 0; k < 3; k++) coordinates[k][i] = entry.lower[k][g] + at.read(entry.fieldBits[k][g]);
      return;
    }
    uint64_t fields = at.peek();
    for (int k = 0; k < 3; k++) {
      const uint32_t bits = entry.fieldBits[k][g];
      coordinates[k][i] = entry.lower[k][g] + uint32_t(fields & ((uint64_t(1) << bits) - 1));
      fields >>= bits;
    }
  }

  /*! Decodes the vertices of group g. ownMask: vertices that belong to it. otherIndices: indices in the block of
   *  other groups' vertices. */
  __forceinline void decodeVertices(const MeshBlockEntry& entry, uint32_t g, uint32_t vertexCount, uint32_t ownMask,
                                    BitReader otherIndices, MeshVertices& out) const {
    alignas(64) uint32_t coordinates[3][32];
    readCoordinates(entry, g, vertexCount, ownMask, otherIndices, coordinates);
    if (isSheared()) unshear(vertexCount, coordinates);
    for (uint32_t k = 0; k < 3; k++) {
      if (unlikely(hasRanks(block->spacings, k))) {
        const uint32_t origin = rankOfFloat(block->origin[k]);
        for (uint32_t i = 0; i < vertexCount; i++) out.at[k][i] = floatOfRank(origin + coordinates[k][i]);
        continue;
      }
      const vfloatV origin(block->origin[k]), spacing(meshSpacing(block->spacings, k));
      for (uint32_t n = 0; n < vertexCount; n += vectorWidth)
        vfloatV::store(out.at[k] + n, origin + vfloatV(vintV::load((const int*)coordinates[k] + n)) * spacing);
    }
  }

  /*! Sets the coordinates of a group's vertices, before the shear is subtracted. Parameters: see
   *  decodeVertices. */
  __forceinline void readCoordinates(const MeshBlockEntry& entry, uint32_t g, uint32_t vertexCount, uint32_t ownMask,
                                     BitReader otherIndices, uint32_t (*coordinates)[32]) const {
    const uint32_t otherBits = bitsFor(meshVertices(block->counts));
    uint32_t first = entry.firstVertex[g];
#if defined(__AVX2__)
    const __m128i isWide = _mm_cmpgt_epi8(_mm_load_si128((const __m128i*)entry.fieldBits[3]), _mm_set1_epi8(57));
    if (likely((uint32_t(_mm_movemask_epi8(isWide)) & entry.lanes) == 0)) {
      readSixteen(entry, first, vertexCount, ownMask, otherIndices, otherBits, coordinates, 0);
      if (likely(vertexCount <= 16)) return;
      const uint32_t owned = uint32_t(__builtin_popcount(ownMask & 0xFFFF));
      otherIndices.skip((16 - owned) * otherBits);
      readSixteen(entry, first + owned, vertexCount - 16, ownMask >> 16, otherIndices, otherBits, coordinates, 16);
      return;
    }
#endif
    for (uint32_t rest = ownMask; rest; rest &= rest - 1, first++)
      readVertex(entry, g, entry.fieldBitOfVertex(first, g), coordinates, uint32_t(__builtin_ctz(rest)));
    for (uint32_t rest = ~ownMask & ((1u << vertexCount) - 1); rest; rest &= rest - 1) {
      const uint32_t v = otherIndices.read(otherBits), owner = groupOfVertex(entry, v);
      readVertex(entry, owner, entry.fieldBitOfVertex(v, owner), coordinates, uint32_t(__builtin_ctz(rest)));
    }
  }

#if defined(__AVX2__)
  /*! Table with a value per group. */
  struct PerGroup {
    const __m256i lower, upper;

    __forceinline explicit PerGroup(const uint32_t* values)
      : lower(_mm256_load_si256((const __m256i*)values)),
        upper(_mm256_load_si256((const __m256i*)values + 1)) {}

    /*! Values of eight groups, 0 to 15. */
    __forceinline __m256i at(__m256i groups) const {
#if defined(__AVX512VL__)
      return _mm256_permutex2var_epi32(lower, groups, upper);
#else
      const __m256 isUpper = _mm256_castsi256_ps(_mm256_slli_epi32(groups, 28)); // bit 3 selects the upper half
      return _mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(_mm256_permutevar8x32_epi32(lower, groups)),
                                                  _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(upper, groups)),
                                                  isUpper));
#endif
    }
  };

  /*! 16-bit words from their lower and upper bytes. */
  static __forceinline __m256i wordsOfBytes(__m128i lower, __m128i upper) {
    return _mm256_set_m128i(_mm_unpackhi_epi8(lower, upper), _mm_unpacklo_epi8(lower, upper));
  }

  /*! Requires words < 256. */
  static __forceinline __m128i bytesOfWords(__m256i words) {
    return _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
  }

  /*! Reads `count` fields of otherBits bits: indices of other groups' vertices. Returns the field with the index
   *  that each byte of `rank` contains. */
  static __forceinline __m256i readOtherIndices(BitReader otherIndices, uint32_t otherBits, uint32_t count,
                                                __m128i rank) {
    // field k becomes 16-bit word 4 (k mod 4) + k/4; a byte of -2 or -1 in a shuffle returns 0
    const __m256i mask = _mm256_set1_epi64x((1 << otherBits) - 1),
                  shifts = _mm256_mul_epu32(_mm256_set1_epi64x(otherBits), _mm256_setr_epi64x(0, 1, 2, 3));
    __m256i words = _mm256_setzero_si256();
    for (uint32_t k = 0; k < count; k += 4, otherIndices.skip(4 * otherBits))
      words = _mm256_or_si256(
          words,
          _mm256_sllv_epi64(
              _mm256_and_si256(mask, _mm256_srlv_epi64(_mm256_set1_epi64x((long long)otherIndices.peek()), shifts)),
              _mm256_set1_epi64x(4 * k)));
    const __m128i one = _mm_set1_epi8(1),
                  inLower =
                      _mm_shuffle_epi8(_mm_setr_epi8(0, 8, -2, -2, 2, 10, -2, -2, 4, 12, -2, -2, 6, 14, -2, -2), rank),
                  inUpper =
                      _mm_shuffle_epi8(_mm_setr_epi8(-2, -2, 0, 8, -2, -2, 2, 10, -2, -2, 4, 12, -2, -2, 6, 14), rank);
    const __m256i lower = wordsOfBytes(inLower, _mm_or_si128(inLower, one)),
                  upper = wordsOfBytes(inUpper, _mm_or_si128(inUpper, one));
    return _mm256_or_si256(_mm256_shuffle_epi8(_mm256_permute4x64_epi64(words, 0x44), lower),
                           _mm256_shuffle_epi8(_mm256_permute4x64_epi64(words, 0xEE), upper));
  }

  /*! readCoordinates for the first 16 of vertexCount vertices, if no group has more than 57 bits per vertex.
   *  first: index in the block of the first own vertex. n: first output lane. */
  __forceinline void readSixteen(const MeshBlockEntry& entry, uint32_t first, uint32_t vertexCount, uint32_t ownMask,
                                 BitReader otherIndices, uint32_t otherBits, uint32_t (*coordinates)[32],
                                 uint32_t n) const {
    const uint32_t numOthers = uint32_t(__builtin_popcount(~ownMask & (0xFFFFu >> (16 - min(vertexCount, 16u)))));
    const __m128i isOwn = bytesOfBits(ownMask),
                  ownRank = _mm_add_epi8(prefixSumsOfBytes(_mm_and_si128(isOwn, _mm_set1_epi8(1))), isOwn),
                  otherRank =
                      _mm_sub_epi8(_mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15), ownRank);
    const __m256i isPresent = _mm256_cmpgt_epi16(
        _mm256_set1_epi16(short(vertexCount)), _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    const __m256i vertex = _mm256_and_si256(
        isPresent, _mm256_blendv_epi8(readOtherIndices(otherIndices, otherBits, numOthers, otherRank),
                                      _mm256_add_epi16(_mm256_cvtepu8_epi16(ownRank), _mm256_set1_epi16(short(first))),
                                      _mm256_cvtepi8_epi16(isOwn)));

    // the group of each vertex: 15 minus the number of groups that begin after it
    __m256i groups = _mm256_set1_epi16(15);
    for (int g = 1; g < 16; g++)
      groups = _mm256_add_epi16(groups, _mm256_cmpgt_epi16(_mm256_set1_epi16(short(entry.firstVertex[g])), vertex));
    const __m128i group = bytesOfWords(groups);
    auto ofGroup = [&](const void* bytes) { return _mm_shuffle_epi8(_mm_load_si128((const __m128i*)bytes), group); };

    // bit: see fieldBitOfVertex
    const __m256i bitOfVertex0 = _mm256_load_si256((const __m256i*)entry.fieldBitOfVertex0),
                  byte = _mm256_set1_epi16(255);
    const __m128i lowerBytes = bytesOfWords(_mm256_and_si256(bitOfVertex0, byte)),
                  upperBytes = bytesOfWords(_mm256_srli_epi16(bitOfVertex0, 8));
    const __m256i bit =
        _mm256_add_epi16(wordsOfBytes(_mm_shuffle_epi8(lowerBytes, group), _mm_shuffle_epi8(upperBytes, group)),
                         _mm256_mullo_epi16(vertex, _mm256_cvtepu8_epi16(ofGroup(entry.fieldBits[3]))));
    alignas(32) uint16_t at[16];
    _mm256_store_si256((__m256i*)at, _mm256_srli_epi16(bit, 3));
    alignas(16) uint8_t sizes[4][16]; // bits before the fields, and of each field
    _mm_store_si128((__m128i*)sizes[0], bytesOfWords(_mm256_and_si256(bit, _mm256_set1_epi16(7))));
    for (int k = 0; k < 3; k++) _mm_store_si128((__m128i*)sizes[k + 1], ofGroup(entry.fieldBits[k]));

    const uint8_t* const data = (const uint8_t*)block + entry.verticesBegin / 8;
    for (uint32_t i = 0; i < vertexCount && i < 16; i += 8) {
      __m256i halves[2][3];
      for (uint32_t half = 0; half < 2; half++) {
        const uint32_t j = i + 4 * half;
        auto four = [&](int k) { return _mm256_cvtepu8_epi64(_mm_cvtsi32_si128(*(const int*)(sizes[k] + j))); };
        auto load = [&](uint32_t lane) {
          long long fields;
          memcpy(&fields, data + at[lane], sizeof(fields));
          return fields;
        };
        __m256i fields = _mm256_srlv_epi64(_mm256_set_epi64x(load(j + 3), load(j + 2), load(j + 1), load(j)), four(0));
        for (int k = 0; k < 3; k++) {
          const __m256i size = four(k + 1);
          halves[half][k] = _mm256_andnot_si256(_mm256_sllv_epi64(_mm256_set1_epi64x(-1), size), fields);
          fields = _mm256_srlv_epi64(fields, size);
        }
      }
      const __m256i eightGroups =
          _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(i == 0 ? _mm_cvtsi128_si64(group) : _mm_extract_epi64(group, 1)));
      for (int k = 0; k < 3; k++) {
        const __m256i packed = _mm256_permute4x64_epi64(
            _mm256_castps_si256(_mm256_shuffle_ps(_mm256_castsi256_ps(halves[0][k]), _mm256_castsi256_ps(halves[1][k]),
                                                  _MM_SHUFFLE(2, 0, 2, 0))),
            _MM_SHUFFLE(3, 1, 2, 0));
        _mm256_store_si256((__m256i*)(coordinates[k] + n + i),
                           _mm256_add_epi32(packed, PerGroup(entry.lower[k]).at(eightGroups)));
      }
    }
  }
#endif

  /*! Subtracts the shear (meshShear) from coordinates on the sheared axis. */
  __forceinline void unshear(uint32_t vertexCount, uint32_t (*coordinates)[32]) const {
    const int m = int(meshShearedAxis(block->info));
    const vintV s1(meshSlope(block->info, 1)), s2(meshSlope(block->info, 2));
    int *const c = (int*)coordinates[m], *const c1 = (int*)coordinates[axisAfter(m, 1)],
               *const c2 = (int*)coordinates[axisAfter(m, 2)];
    for (uint32_t n = 0; n < vertexCount; n += vectorWidth)
      vintV::store(c + n, vintV::load(c + n) - ((s1 * vintV::load(c1 + n) + s2 * vintV::load(c2 + n) + vintV(8)) >> 4));
  }

  const MeshHeader* const block;
};
} // namespace embree::isa::cbvh
