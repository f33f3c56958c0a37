// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The kinds of blocks, one number each. From the number follow the kind in the header of a block
 * with a frame (framed/block.h), references of flat scenes and on Vulkan devices (reference.h), the
 * value of RTCCompression, and by the rows below keys of device strings and the words of programs.
 *
 * A kind that goes takes with it its number and its rows here, its row where the encoder and the intersectors
 * choose (block_encoder.h, framed_rays1.h, framed_raysK.h, cbvh.glsl and framed_block.glsl), and its folder. The
 * numbers of others stay: blocks have them. framed/writer.h gives cGRID the blocks that no frame fits, and
 * cLEAF the patches with holes of kinds that take none. */

#ifndef CBVH_KINDS_H
#define CBVH_KINDS_H

#include "language.h"
#include "../../cvert/format/limits.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t kindGrid = 0u;
CVERT_CONSTANT uint32_t kindVoxel = 1u;
CVERT_CONSTANT uint32_t kindLeaf = 2u;
CVERT_CONSTANT uint32_t kindVert = 3u;

/*! numbers that references have room for, and, of those, headers of blocks with frames */
CVERT_CONSTANT uint32_t maxKinds = 18u;
CVERT_CONSTANT uint32_t maxFramedKinds = 16u;

/*! bits of the numbers of those with frames */
CVERT_CONSTANT uint32_t framedKinds = (1u << kindGrid) | (1u << kindVoxel) | (1u << kindLeaf);

/*! quads of a patch in blocks with frames are at most 2^maxLevel along a side */
CVERT_CONSTANT uint32_t maxLevel = 8u;

/*! what the layout of a block with a frame depends on */
struct KindFormat
{
  uint32_t leafLevels;    //!< log2 of the quads along a side of a leaf, where there are that many
  uint32_t minNodeLevels; //!< leaves of smaller blocks are parts of a quad
  uint32_t groupBytes;    //!< behind the words: for each word of the last level
  uint32_t vertexBytes;   //!< for each vertex
  uint32_t padding;       //!< bytes behind all
};

/*! by number, zeros where it is no kind's */
CVERT_CONSTANT uint32_t numKindFormats = 3u;
CVERT_CONSTANT KindFormat kindFormats[numKindFormats] = {
  /* cGRID: a leaf is 2 x 2 quads, as GRID's own; vectors that read its last row read 3 floats more */
  { 1u, 0u, 0u, 12u, 12u },
  /* cVOXEL */
  { 0u, 0u, 0u, 0u, 0u },
  /* cLEAF: words of the last level are groups of 2 x 2 leaves with heights; one quad is cut into four */
  { 0u, 1u, 8u, 0u, 0u }
};

CBVH_END

#ifndef VULKAN
#include "../../../include/embree3/rtcore_compression.h"

CBVH_BEGIN

enum class Kind : uint32_t { GRID = kindGrid, VOXEL = kindVoxel, LEAF = kindLeaf, VERT = kindVert };

/*! what is to know of a kind besides its bytes */
struct KindDescription
{
  Kind kind;
  const char* key;           //!< in device strings, after "cbvh.", and in EMBREE_CBVH; after "c" in command lines of programs
  const char* name;          //!< in messages
  bool alignsToLimit;        //!< frames align to corners before displacement, else after it
  bool takesHoles;           //!< leaves can leave a quad out
  bool hasThickness;         //!< leaves are not exact: a bound on their thickness means something

  bool hasFrame () const { return ((framedKinds >> uint32_t(kind)) & 1u) != 0u; }
  RTCCompression compression () const { return RTCCompression(RTC_COMPRESSION_GRID + uint32_t(kind)); }
};

/*! Heights are best stored along the normal of the smooth surface; boxes are tightest around what
 *  they bound. */
static constexpr KindDescription kindDescriptions[] = {
#if !defined(EMBREE_CBVH_NO_PAPER)
  { Kind::GRID,  "grid",  "cGRID",  false, true,  false },
  { Kind::VOXEL, "voxel", "cVOXEL", false, false, true  },
  { Kind::LEAF,  "leaf",  "cLEAF",  true,  true,  true  },
#endif
  { Kind::VERT,  "vert",  "cVERT",  false, true,  false }
};
static constexpr uint32_t numKinds = sizeof(kindDescriptions)/sizeof(kindDescriptions[0]);

static_assert(framedKinds < (1u << maxFramedKinds), "headers of blocks with frames have 4 bits for the kind");
static_assert(RTC_COMPRESSION_VOXEL - RTC_COMPRESSION_GRID == kindVoxel, "a value of RTCCompression follows from the kind");
static_assert(RTC_COMPRESSION_LEAF  - RTC_COMPRESSION_GRID == kindLeaf,  "a value of RTCCompression follows from the kind");
static_assert(RTC_COMPRESSION_VERT  - RTC_COMPRESSION_GRID == kindVert,  "a value of RTCCompression follows from the kind");

/*! kind: one that this library was built with */
inline const KindDescription& describe (Kind kind)
{
  uint32_t row = 0;
  while (kindDescriptions[row].kind != kind) row++;
  return kindDescriptions[row];
}

/*! kind of an RTCCompression; false for those that are none */
inline bool findKind (int compression, Kind& kind)
{
  for (const KindDescription& description : kindDescriptions)
    if (description.compression() == compression) { kind = description.kind; return true; }
  return false;
}

/*! Compression of a geometry in a file whose record has that one. A library that was built without it loads only
 *  files of cVERT blocks. */
inline RTCCompression compressionOfLoaded (uint32_t compression)
{
  Kind kind;
  return findKind(int(compression),kind) ? RTCCompression(compression) : RTC_COMPRESSION_VERT;
}

CBVH_END
#endif

#endif
