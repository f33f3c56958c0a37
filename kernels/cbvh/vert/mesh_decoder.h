// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of mesh blocks, cvert/format/mesh_block.h: the boxes of all groups, then the triangles of a group at a time.
 * cvert/decoder/decoded_mesh.h is the scalar reference. Reads up to 8 bytes after the block. */

#include "../base/codec.h"
#include "../base/vectors.h"
#include "../../cvert/format/mesh_block.h"
#include "mesh_cache.h"
#include <cmath>

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      class MeshDecoder
      {
      public:
        __forceinline explicit MeshDecoder (const MeshHeader* block) : block(block) {}

        /*! Decodes the boxes of all groups, and finds where the groups are. */
        __forceinline void decode (MeshBoxes& out) const
        {
          const uint32_t groups = meshGroups(block->counts);
          out.lanes = (1u << groups)-1;
          setAxes(out);
          decodeBoxes(groups,out);
          findGroups(groups,out);
        }

        /*! Decodes the triangles of group g. */
        __forceinline void triangles (const MeshBoxes& boxes, uint32_t g, MeshTriangles& out) const
        {
          const uint32_t group = meshGroupByte(block,g), record = meshRecord(block,g), count = groupTriangles(group),
            locals = groupVertices(record), stream = streamLength(count,groupRestarts(group,record)),
            repeatBits = bitsFor(locals);
          Bits at(block,boxes.topology[g]);
          const uint32_t restarts = at.take(count-1) << 1, fans = at.take(count-1) << 1;
          uint64_t turns = at.take(min(2*count,32u));
          if (unlikely(count > 16)) turns |= uint64_t(at.take(2*count-32)) << 32;
          uint64_t news = at.take(min(stream-3,32u));
          if (unlikely(stream-3 > 32)) news |= uint64_t(at.take(stream-3-32)) << 32;
          const uint32_t owns = at.take(locals);
          Bits repeats = at;
          at.skip((stream-locals)*repeatBits);

          alignas(64) float positions[3][32];
          decodeVertices(boxes,g,locals,owns,at,positions);

          alignas(32) uint8_t corners[3][maxGroupTriangles];
          Strip strip;
          uint32_t fresh = 3;
          auto next = [&]() {
            const uint32_t isNew = uint32_t(news) & 1, old = repeats.peek() & ((1u << repeatBits)-1);
            news >>= 1;
            const uint32_t v = isNew ? fresh : old;
            fresh += isNew;
            repeats.skip(isNew ? 0 : repeatBits);
            return v;
          };
          for (uint32_t t=0; t<count; t++)
          {
            if (unlikely((restarts >> t) & 1)) {
              strip.a = next();
              strip.b = next();
              strip.c = next();
              strip.isFlipped = 0;
            }
            else if (t > 0) strip.add(next(),(fans >> t) & 1);
            const uint32_t v = strip.corners(uint32_t(turns >> (2*t)) & 3);
            for (int c=0; c<3; c++) corners[c][t] = uint8_t(v >> (8*c));
          }
          out.lanes = 0xFFFFFFFFu >> (32-count);
          gather(corners,positions,count,locals,out);
        }

        /*! Returns the number of triangle t of group g (primitiveOfMesh). */
        __forceinline uint32_t number (const MeshBoxes& boxes, uint32_t g, uint32_t t) const
        {
          const uint32_t baseBits = baseNumberBits(block->counts), bits = groupNumberBits(meshRecord(block,g));
          Bits at(block,boxes.numbers[g]);
          const uint32_t base = at.take(baseBits);
          at.skip(t*bits);
          return block->primID + base + at.take(bits);
        }

      private:
        /*! a position in the bits of the block */
        struct Bits
        {
          const uint8_t* data;
          uint32_t bit;

          __forceinline Bits (const MeshHeader* block, uint32_t bit) : data((const uint8_t*)block), bit(bit) {}

          /*! the next 57 bits, and up to 7 others above them */
          __forceinline uint64_t wide () const
          {
            uint64_t word;
            memcpy(&word,data + (bit >> 3),sizeof(word));
            return word >> (bit & 7);
          }
          __forceinline uint32_t peek () const { return uint32_t(wide()); }
          __forceinline void skip (uint32_t count) { bit += count; }
          __forceinline uint32_t take (uint32_t count) // up to 32
          {
            const uint32_t value = uint32_t(wide() & ((uint64_t(1) << count)-1));
            bit += count;
            return value;
          }
        };

        /*! the last triangle of a strip; vertices are numbers in the group */
        struct Strip
        {
          uint32_t a = 0, b = 1, c = 2, isFlipped = 0;

          __forceinline void add (uint32_t vertex, uint32_t isFan)
          {
            a = isFan ? a : b;
            b = c;
            c = vertex;
            isFlipped ^= isFan ^ 1;
          }

          /*! Returns the corners in the order of the application, 8 bits each. */
          __forceinline uint32_t corners (uint32_t turn) const
          {
            const uint64_t v = (isFlipped ? b | a << 8 : a | b << 8) | c << 16;
            return uint32_t((v | v << 24) >> (8*turn));
          }
        };

        /*! bitsForBelow() */
        static __forceinline uint32_t bitsFor (uint32_t count) { return count < 2 ? 0 : 32-uint32_t(__builtin_clz(count-1)); }

        __forceinline bool isSheared () const { return (block->form & 0x03FF0000u) != 0; }
        __forceinline bool hasAnyRanks () const {
          return hasRanks(block->spacings,0) || hasRanks(block->spacings,1) || hasRanks(block->spacings,2);
        }

        /*! Shears of boxes in the world: the sheared axis counts 1, and the others their slopes, by the ratio of spacings.
         *  A block with ratios that floats do not hold well has boxes without bounds on the sheared axis. */
        __forceinline void setAxes (MeshBoxes& out) const
        {
          out.axis = 3;
          for (int k=0; k<3; k++) { out.origin[k] = block->origin[k]; out.shear[k] = 0.0f; }
          if (likely(!isSheared())) return;
          const int m = int(meshShearedAxis(block->form));
          for (int i=1; i<3; i++)
            if (exponentRatio(m,i) < -maxRatio || exponentRatio(m,i) > maxRatio) return;
          out.axis = m;
          out.shear[m] = 1.0f;
          for (int i=1; i<3; i++)
            out.shear[axisAfter(m,i)] = float(meshSlope(block->form,uint32_t(i)))*(1.0f/16.0f)
              *floatOfBits(uint32_t(exponentRatio(m,i)+127) << 23);
        }

        static const int maxRatio = 30; //!< of spacings, as an exponent

        __forceinline int exponentRatio (int m, int i) const
        {
          auto exponent = [&](int k) { return int((block->spacings >> (8*k)) & 255); };
          return exponent(m) - exponent(axisAfter(m,i));
        }

        /*! planes of boxes, and extents from the origin */
        __forceinline void decodeBoxes (uint32_t groups, MeshBoxes& out) const
        {
          const uint8_t* const bytes = (const uint8_t*)block + meshLayout(block->counts).boxes;
          float reach[3]; // of coordinates
          for (int k=0; k<3; k++)
          {
            const uint32_t shift = meshBoxShift(block->spacings,block->form,uint32_t(k));
            if (unlikely(hasRanks(block->spacings,uint32_t(k)))) {
              decodeRankedBoxes(k,bytes,groups,shift,out);
              reach[k] = 0.0f;
              continue;
            }
            const bool sheared = isSheared() && uint32_t(k) == meshShearedAxis(block->form);
            const vfloatV spacing(meshSpacing(block->spacings,uint32_t(k))), origin(sheared ? 0.0f : block->origin[k]),
              rounding(sheared ? 0.5f : 0.0f);
            vfloatV highest(zero);
            for (int n=0; n<16; n+=vectorWidth)
            {
              const vintV lower = loadBytes(bytes + uint32_t(k)*groups + n) << int(shift),
                upper = lower + ((loadBytes(bytes + uint32_t(3+k)*groups + n) + vintV(1)) << int(shift));
              vintV::storeu(&out.lower[k][n],lower);
              const vfloatV begin(lower), end(upper);
              vfloatV::store(out.planes[k].at[0]+n,origin + (begin-rounding)*spacing);
              vfloatV::store(out.planes[k].at[1]+n,origin + end*spacing);
              highest = max(highest,select(vintV(n)+vintV(step) < vintV(int(groups)),end,vfloatV(zero)));
            }
            reach[k] = reduce_max(highest);
            out.extent[k] = reach[k]*meshSpacing(block->spacings,uint32_t(k));
          }
          if (likely(!isSheared())) return;
          const int m = int(meshShearedAxis(block->form));
          for (int i=1; i<3; i++)
            reach[m] += std::fabs(float(meshSlope(block->form,uint32_t(i))))*(1.0f/16.0f)*reach[axisAfter(m,i)];
          out.extent[m] = (reach[m]+1.0f)*meshSpacing(block->spacings,uint32_t(m));
          if (unlikely(out.axis == 3))
            for (int l=0; l<16; l++) { out.planes[m].at[0][l] = -1e30f; out.planes[m].at[1][l] = 1e30f; }
        }

        void decodeRankedBoxes (int k, const uint8_t* bytes, uint32_t groups, uint32_t shift, MeshBoxes& out) const
        {
          const uint32_t origin = rankOfFloat(block->origin[k]);
          out.extent[k] = 0.0f;
          for (uint32_t l=0; l<16; l++) {
            const uint32_t g = min(l,groups-1), lower = uint32_t(bytes[uint32_t(k)*groups+g]) << shift;
            out.lower[k][l] = lower;
            out.planes[k].at[0][l] = floatOfRank(origin+lower);
            out.planes[k].at[1][l] = floatOfRank(origin+lower + ((bytes[uint32_t(3+k)*groups+g]+1u) << shift)-1u);
            out.extent[k] = max(out.extent[k],out.planes[k].at[1][l]-block->origin[k]);
          }
        }

        static __forceinline vintV loadBytes (const uint8_t* p)
        {
#if defined(__AVX512F__)
          return vintV(_mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i*)p)));
#elif defined(__AVX2__)
          return vintV(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)p)));
#else
          alignas(64) int lanes[vectorWidth];
          for (int i=0; i<vectorWidth; i++) lanes[i] = p[i];
          return vintV::load(lanes);
#endif
        }

        /*! sums over groups: MeshView */
        __forceinline void findGroups (uint32_t groups, MeshBoxes& out) const
        {
          const uint8_t* const bytes = (const uint8_t*)block;
          const MeshLayout layout = meshLayout(block->counts);
          const uint32_t otherBits = bitsFor(meshVertices(block->counts)), baseBits = baseNumberBits(block->counts);
          uint32_t shifts[3], topology = 8*layout.topology, vertices = 0, numbers = 0, firstVertex = 0;
          for (uint32_t k=0; k<3; k++) shifts[k] = meshBoxShift(block->spacings,block->form,k);
          for (uint32_t g=0; g<groups; g++)
          {
            const uint32_t group = meshGroupByte(block,g), record = meshRecord(block,g), count = groupTriangles(group),
              stream = streamLength(count,groupRestarts(group,record)), locals = groupVertices(record),
              own = groupOwnVertices(record);
            uint32_t bits[3];
            for (uint32_t k=0; k<3; k++) bits[k] = bitsFor((bytes[layout.boxes + (3+k)*groups + g]+1u) << shifts[k]);
            for (uint32_t k=0; k<3; k++) // 2^32 wraps to 0, and has 32 bits; 1 has none
              if (unlikely(((bytes[layout.boxes + (3+k)*groups + g]+1u) << shifts[k]) == 0)) bits[k] = 32;
            const uint32_t sum = bits[0]+bits[1]+bits[2];
            out.topology[g] = topology;
            out.vertices[g] = vertices;
            out.numbers[g] = numbers;
            out.fieldBits[g] = bits[0] | bits[1] << 8 | bits[2] << 16 | sum << 24;
            out.firstVertex[g] = uint16_t(firstVertex);
            topology += 2*(count-1) + 2*count + stream-3 + locals + (stream-locals)*bitsFor(locals) + (locals-own)*otherBits;
            vertices += own*sum;
            numbers += baseBits + count*groupNumberBits(record);
            firstVertex += own;
          }
          for (uint32_t g=groups; g<16; g++) out.firstVertex[g] = 0x7FFF;
          const uint32_t verticesBegin = (topology+7) & ~7u, numbersBegin = (verticesBegin+vertices+7) & ~7u;
          for (uint32_t g=0; g<groups; g++) {
            out.vertices[g] += verticesBegin;
            out.numbers[g] += numbersBegin;
          }
        }

        /*! Returns the group that a vertex of the block belongs to. */
        static __forceinline uint32_t groupOfVertex (const MeshBoxes& boxes, uint32_t v)
        {
          const __m128i vertex = _mm_set1_epi16(short(v)), * const first = (const __m128i*)boxes.firstVertex;
          const __m128i after = _mm_packs_epi16(_mm_cmpgt_epi16(_mm_load_si128(first),vertex),
            _mm_cmpgt_epi16(_mm_load_si128(first+1),vertex));
          return uint32_t(__builtin_ctz(uint32_t(_mm_movemask_epi8(after)) | 0x10000u)) - 1;
        }

        /*! Decodes the vertices that a group uses. owns: which belong to it; others: the numbers of the others */
        __forceinline void decodeVertices (const MeshBoxes& boxes, uint32_t g, uint32_t locals, uint32_t owns, Bits others,
                                           float (*positions)[32]) const
        {
          alignas(64) uint32_t coordinates[3][32];
          const uint32_t otherBits = bitsFor(meshVertices(block->counts));
          uint32_t own = boxes.vertices[g];
          for (uint32_t i=0; i<locals; i++)
          {
            uint32_t of = g, bit = own;
            if ((owns >> i) & 1) own += boxes.fieldBits[g] >> 24;
            else {
              const uint32_t v = others.take(otherBits);
              of = groupOfVertex(boxes,v);
              bit = boxes.vertices[of] + (v-boxes.firstVertex[of])*(boxes.fieldBits[of] >> 24);
            }
            const uint32_t bits = boxes.fieldBits[of];
            Bits at(block,bit);
            if (likely(bits >> 24 <= 57)) {
              const uint64_t fields = at.wide();
              const uint32_t x = bits & 255, xy = x + ((bits >> 8) & 255);
              coordinates[0][i] = boxes.lower[0][of] + uint32_t(fields & ((uint64_t(1) << x)-1));
              coordinates[1][i] = boxes.lower[1][of] + uint32_t((fields >> x) & ((uint64_t(1) << ((bits >> 8) & 255))-1));
              coordinates[2][i] = boxes.lower[2][of] + uint32_t((fields >> xy) & ((uint64_t(1) << ((bits >> 16) & 255))-1));
            }
            else for (int k=0; k<3; k++) coordinates[k][i] = boxes.lower[k][of] + at.take((bits >> (8*k)) & 255);
          }
          if (isSheared()) unshear(locals,coordinates);
          for (uint32_t k=0; k<3; k++)
          {
            if (unlikely(hasRanks(block->spacings,k))) {
              const uint32_t origin = rankOfFloat(block->origin[k]);
              for (uint32_t i=0; i<locals; i++) positions[k][i] = floatOfRank(origin + coordinates[k][i]);
              continue;
            }
            const vfloatV origin(block->origin[k]), spacing(meshSpacing(block->spacings,k));
            for (uint32_t n=0; n<locals; n+=vectorWidth)
              vfloatV::store(positions[k]+n,origin + vfloatV(vintV::load((const int*)coordinates[k]+n))*spacing);
          }
        }

        __forceinline void unshear (uint32_t locals, uint32_t (*coordinates)[32]) const
        {
          const int m = int(meshShearedAxis(block->form));
          const vintV s1(meshSlope(block->form,1)), s2(meshSlope(block->form,2));
          int* const c = (int*)coordinates[m], * const c1 = (int*)coordinates[axisAfter(m,1)],
            * const c2 = (int*)coordinates[axisAfter(m,2)];
          for (uint32_t n=0; n<locals; n+=vectorWidth)
            vintV::store(c+n,vintV::load(c+n) - ((s1*vintV::load(c1+n) + s2*vintV::load(c2+n) + vintV(8)) >> 4));
        }

        static __forceinline void gather (const uint8_t (*corners)[maxGroupTriangles], const float (*positions)[32],
                                          uint32_t count, uint32_t, MeshTriangles& out)
        {
          for (int c=0; c<3; c++)
            for (uint32_t t=0; t<count; t++)
              for (int k=0; k<3; k++) out.at[c][k][t] = positions[k][corners[c][t]];
        }

        const MeshHeader* const block;
      };
    }
  }
}
