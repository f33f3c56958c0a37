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
          Bits at(block,boxes.topologyBegin+boxes.topology[g]);
          const uint32_t restarts = at.take(count-1) << 1, fans = at.take(count-1) << 1;
          uint64_t turns = at.take(min(2*count,32u));
          if (unlikely(count > 16)) turns |= uint64_t(at.take(2*count-32)) << 32;
          uint64_t news = at.take(min(stream-3,32u));
          if (unlikely(stream-3 > 32)) news |= uint64_t(at.take(stream-3-32)) << 32;
          const uint32_t owns = at.take(locals);
          Bits repeats = at;
          at.skip((stream-locals)*repeatBits);
          decodeVertices(boxes,g,locals,owns,at,out.at);
          out.numVertices = locals;
          out.lanes = 0xFFFFFFFFu >> (32-count);

          Strip strip;
          uint32_t fresh = 3;
          auto next = [&]() {
            const uint32_t isNew = uint32_t(news) & 1, old = repeats.peek() & ((1u << repeatBits)-1);
            news >>= 1;
            const uint32_t v = isNew ? fresh : old;
            fresh += isNew;
            repeats.skip(repeatBits & (isNew-1));
            return v;
          };
          set(out,0,strip.corners(uint32_t(turns) & 3));
          for (uint32_t t=1; t<count; t++)
          {
            if (unlikely((restarts >> t) & 1)) {
              strip.a = next();
              strip.b = next();
              strip.c = next();
              strip.isFlipped = 0;
            }
            else strip.add(next(),(fans >> t) & 1);
            turns >>= 2;
            set(out,t,strip.corners(uint32_t(turns) & 3));
          }
        }

        /*! Returns the number of triangle t of group g (primitiveOfMesh). */
        __forceinline uint32_t number (const MeshBoxes& boxes, uint32_t g, uint32_t t) const
        {
          const uint32_t baseBits = baseNumberBits(block->counts), bits = groupNumberBits(meshRecord(block,g));
          Bits at(block,boxes.numbersBegin+boxes.numbers[g]);
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
            a ^= (a ^ b) & (isFan-1); // without a branch, which a processor would not foresee
            b = c;
            c = vertex;
            isFlipped ^= isFan ^ 1;
          }

          /*! Returns the corners in the order of the application, 8 bits each. */
          __forceinline uint32_t corners (uint32_t turn) const
          {
            const uint32_t swapped = (a ^ b) & (0-isFlipped);
            const uint64_t v = (a ^ swapped) | (b ^ swapped) << 8 | c << 16;
            return uint32_t((v | v << 24) >> (8*turn));
          }
        };

        static __forceinline void set (MeshTriangles& out, uint32_t t, uint32_t corners) {
          for (int c=0; c<3; c++) out.corners[c][t] = uint8_t(corners >> (8*c));
        }

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

        /*! bits of the numbers in 16 bytes */
        static __forceinline __m128i lengthsOf (__m128i bytes)
        {
#if defined(__SSSE3__)
          const __m128i nibble = _mm_set1_epi8(15);
          return _mm_max_epu8(_mm_shuffle_epi8(_mm_setr_epi8(0,1,2,2,3,3,3,3,4,4,4,4,4,4,4,4),_mm_and_si128(bytes,nibble)),
            _mm_shuffle_epi8(_mm_setr_epi8(0,5,6,6,7,7,7,7,8,8,8,8,8,8,8,8),_mm_and_si128(_mm_srli_epi16(bytes,4),nibble)));
#else
          __m128i lengths = _mm_setzero_si128();
          for (int bit=0; bit<8; bit++) // a number has more than `bit` bits if it is at least 2^bit
            lengths = _mm_sub_epi8(lengths,_mm_cmpeq_epi8(_mm_max_epu8(bytes,_mm_set1_epi8(char(1 << bit))),bytes));
          return lengths;
#endif
        }

        /*! Stores sums over the numbers before each of 16; returns the sum of all. */
        static __forceinline uint32_t storeSums (const __m128i numbers[2], uint16_t out[16])
        {
          uint32_t before = 0;
          for (int half=0; half<2; half++)
          {
            __m128i sum = _mm_add_epi16(numbers[half],_mm_slli_si128(numbers[half],2));
            sum = _mm_add_epi16(sum,_mm_slli_si128(sum,4));
            sum = _mm_add_epi16(sum,_mm_slli_si128(sum,8));
            _mm_store_si128((__m128i*)(out+8*half),
              _mm_add_epi16(_mm_sub_epi16(sum,numbers[half]),_mm_set1_epi16(short(before))));
            before += uint32_t(_mm_extract_epi16(sum,7)) & 0xFFFF;
          }
          return before;
        }

        /*! Sums over groups, as MeshView has them. All of them have less than 16 bits. */
        __forceinline void findGroups (uint32_t groups, MeshBoxes& out) const
        {
          const uint8_t* const bytes = (const uint8_t*)block;
          const MeshLayout layout = meshLayout(block->counts);
          const __m128i none = _mm_setzero_si128(), group = _mm_loadu_si128((const __m128i*)block->groups);

          /* a field has the bits of the extent, and the shift's */
          __m128i bits[3], all = none;
          for (uint32_t k=0; k<3; k++) {
            const __m128i extents = _mm_loadu_si128((const __m128i*)(bytes + layout.boxes + (3+k)*groups));
            bits[k] = _mm_add_epi8(lengthsOf(extents),_mm_set1_epi8(char(meshBoxShift(block->spacings,block->form,k))));
            all = _mm_add_epi8(all,bits[k]);
          }
          const __m128i xy[2] = { _mm_unpacklo_epi8(bits[0],bits[1]),_mm_unpackhi_epi8(bits[0],bits[1]) },
            zs[2] = { _mm_unpacklo_epi8(bits[2],all),_mm_unpackhi_epi8(bits[2],all) };
          for (int half=0; half<2; half++) {
            _mm_store_si128((__m128i*)(out.fieldBits+8*half),_mm_unpacklo_epi16(xy[half],zs[half]));
            _mm_store_si128((__m128i*)(out.fieldBits+8*half+4),_mm_unpackhi_epi16(xy[half],zs[half]));
          }

          const uint8_t* const records = bytes + layout.records;
          const __m128i record[2] = { _mm_loadu_si128((const __m128i*)records),
            groups > 8 ? _mm_loadu_si128((const __m128i*)(records+16)) : none }; // a short block ends there
          const __m128i five = _mm_set1_epi16(31);
          __m128i locals[2], topology[2], vertices[2], numbers[2], own[2];
          for (int half=0; half<2; half++) locals[half] = _mm_and_si128(record[half],five);
          const __m128i repeats = lengthsOf(_mm_sub_epi8(_mm_packus_epi16(locals[0],locals[1]),_mm_set1_epi8(1)));
          const __m128i otherBits = _mm_set1_epi16(short(bitsFor(meshVertices(block->counts)))),
            baseBits = _mm_set1_epi16(short(baseNumberBits(block->counts)));
          for (int half=0; half<2; half++)
          {
            auto wide = [&](__m128i x) { return half ? _mm_unpackhi_epi8(x,none) : _mm_unpacklo_epi8(x,none); };
            const __m128i lane = _mm_add_epi16(_mm_setr_epi16(0,1,2,3,4,5,6,7),_mm_set1_epi16(short(8*half))),
              isThere = _mm_cmpgt_epi16(_mm_set1_epi16(short(groups)),lane);
            const __m128i of = wide(group), r = record[half],
              restarts = _mm_or_si128(_mm_srli_epi16(of,5),_mm_and_si128(_mm_srli_epi16(r,12),_mm_set1_epi16(8))),
              count = _mm_add_epi16(_mm_and_si128(of,five),_mm_set1_epi16(1)),
              entries = _mm_add_epi16(count,_mm_add_epi16(restarts,restarts)); // of the stream, less 2
            own[half] = _mm_and_si128(_mm_and_si128(_mm_srli_epi16(r,5),five),isThere);
            __m128i numberBits = _mm_and_si128(_mm_srli_epi16(r,10),five);
            numberBits = _mm_sub_epi16(numberBits,_mm_cmpeq_epi16(numberBits,five));
            /* restarts, fans, turns, news, owns; then repeats, and others */
            __m128i sum = _mm_add_epi16(_mm_slli_epi16(count,2),_mm_add_epi16(entries,locals[half]));
            sum = _mm_sub_epi16(sum,_mm_set1_epi16(3));
            sum = _mm_add_epi16(sum,_mm_mullo_epi16(wide(repeats),
              _mm_sub_epi16(_mm_add_epi16(entries,_mm_set1_epi16(2)),locals[half])));
            sum = _mm_add_epi16(sum,_mm_mullo_epi16(otherBits,_mm_sub_epi16(locals[half],own[half])));
            topology[half] = _mm_and_si128(sum,isThere);
            vertices[half] = _mm_mullo_epi16(own[half],wide(all));
            numbers[half] = _mm_and_si128(_mm_add_epi16(baseBits,_mm_mullo_epi16(count,numberBits)),isThere);
          }
          out.topologyBegin = 8*layout.topology;
          out.verticesBegin = out.topologyBegin + ((storeSums(topology,out.topology)+7) & ~7u);
          out.numbersBegin = out.verticesBegin + ((storeSums(vertices,out.vertices)+7) & ~7u);
          storeSums(numbers,out.numbers);
          storeSums(own,out.firstVertex);
          for (uint32_t g=groups; g<16; g++) out.firstVertex[g] = 0x7FFF;
        }

        /*! Returns the group that a vertex of the block belongs to. */
        static __forceinline uint32_t groupOfVertex (const MeshBoxes& boxes, uint32_t v)
        {
          const __m128i vertex = _mm_set1_epi16(short(v)), * const first = (const __m128i*)boxes.firstVertex;
          const __m128i after = _mm_packs_epi16(_mm_cmpgt_epi16(_mm_load_si128(first),vertex),
            _mm_cmpgt_epi16(_mm_load_si128(first+1),vertex));
          return uint32_t(__builtin_ctz(uint32_t(_mm_movemask_epi8(after)) | 0x10000u)) - 1;
        }

        /*! The fields of a vertex of a group; bits: as in MeshBoxes */
        struct VertexFields
        {
          const MeshBoxes& boxes;
          const uint32_t g, bits;
          const uint64_t masks[3];

          static __forceinline uint64_t maskOf (uint32_t bits) { return (uint64_t(1) << bits)-1; }

          __forceinline VertexFields (const MeshBoxes& boxes, uint32_t g)
            : boxes(boxes), g(g), bits(boxes.fieldBits[g]),
              masks{ maskOf(bits & 255),maskOf((bits >> 8) & 255),maskOf((bits >> 16) & 255) } {}

          __forceinline uint32_t all () const { return bits >> 24; }

          __forceinline void read (Bits at, uint32_t (*coordinates)[32], uint32_t i) const
          {
            uint64_t fields = at.wide();
            if (likely(all() <= 57)) {
              coordinates[0][i] = boxes.lower[0][g] + uint32_t(fields & masks[0]);
              fields >>= bits & 255;
              coordinates[1][i] = boxes.lower[1][g] + uint32_t(fields & masks[1]);
              fields >>= (bits >> 8) & 255;
              coordinates[2][i] = boxes.lower[2][g] + uint32_t(fields & masks[2]);
            }
            else for (int k=0; k<3; k++) coordinates[k][i] = boxes.lower[k][g] + at.take((bits >> (8*k)) & 255);
          }
        };

        /*! Decodes the vertices that a group uses. owns: which belong to it; others: the numbers of the others */
        __forceinline void decodeVertices (const MeshBoxes& boxes, uint32_t g, uint32_t locals, uint32_t owns, Bits others,
                                           float (*positions)[32]) const
        {
          alignas(64) uint32_t coordinates[3][32];
          const uint32_t otherBits = bitsFor(meshVertices(block->counts));
          const VertexFields own(boxes,g);
          uint32_t bit = boxes.verticesBegin+boxes.vertices[g];
          for (uint32_t rest=owns; rest; rest&=rest-1, bit+=own.all())
            own.read(Bits(block,bit),coordinates,uint32_t(__builtin_ctz(rest)));
          for (uint32_t rest=~owns & ((1u << locals)-1); rest; rest&=rest-1)
          {
            const uint32_t v = others.take(otherBits);
            const VertexFields of(boxes,groupOfVertex(boxes,v));
            of.read(Bits(block,boxes.verticesBegin + boxes.vertices[of.g] + (v-boxes.firstVertex[of.g])*of.all()),coordinates,
              uint32_t(__builtin_ctz(rest)));
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

        const MeshHeader* const block;
      };
    }
  }
}
