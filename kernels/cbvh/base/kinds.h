// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Kinds of blocks: the paper's cGRID, cVOXEL and cLEAF, whose blocks have frames (local coordinate systems), cVERT, and
 * cTILE, which stores the blocks of cVERT as tiles (cvert/format/tile.h).
 * Blocks with frames store the number of their kind (paper/block.h), which also determines references (reference.h)
 * and values of RTCCompression: numbers must not change. Compiled as C++ and GLSL.
 *
 * Code in paper/ that selects by kind: block_encoder.h, rays.cpp, and in vulkan/shaders
 * cbvh.glsl and framed_block.glsl. Exceptions for single kinds:
 *
 *   cGRID   paper/writer.h: some blocks without a valid frame become cGRID. paper/block_bounds.h: the bounds of its
 *           vertices contain its surface. blocks/stored_triangles.cpp: its triangles can be read. surface/plan.h:
 *           the default of blockKind.
 *   cLEAF   paper/writer.h: stores patches with holes as cLEAF if their kind does not support holes. surface/plan.h:
 *           has fallback faces. paper/block_geometry.h: has the smallest cells. The format of its leaves
 *           (paper/leaf/format.h) is included by the headers that decode nodes.
 *
 * To remove a kind, remove this code, its folder, its number, its bit in framedKinds and its row of kindDescriptions.
 * Its row of kindFormats must stay, because the rows are indexed by number. */

#ifndef CBVH_BASE_KINDS_H
#define CBVH_BASE_KINDS_H

#include "codec_names.h"
#include "../../cvert/format/limits.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t kindGrid = 0u;
CVERT_CONSTANT uint32_t kindVoxel = 1u;
CVERT_CONSTANT uint32_t kindLeaf = 2u;
CVERT_CONSTANT uint32_t kindVert = 3u;
CVERT_CONSTANT uint32_t kindTile = 4u;

/*! References have room for this many kinds. */
CVERT_CONSTANT uint32_t maxKinds = 18u;

/*! Headers of blocks with frames have 4 bits for the kind. */
CVERT_CONSTANT uint32_t maxFramedKinds = 16u;

/*! Bit mask of the kinds with frames. */
CVERT_CONSTANT uint32_t framedKinds = (1u << kindGrid) | (1u << kindVoxel) | (1u << kindLeaf);

/*! Highest level of a patch that is stored in blocks with frames: 2^maxFramedLevel quads per side. */
CVERT_CONSTANT uint32_t maxFramedLevel = 8u;

struct KindFormat {
  uint32_t leafLevels;     //!< log2 of the quads per side of a leaf, in blocks of at least that many quads per side
  uint32_t minNodeLevels;  //!< minimum levels of nodes; in blocks of less height, leaves are parts of a quad
  uint32_t bytesPerGroup;  //!< size of a group (2 x 2 leaves below a node of the last level) without its word, or 0
  uint32_t bytesPerVertex; //!< 0 if blocks store no vertices
  uint32_t tailPadding;    //!< zeros at the end of a block that decoders may read, part of its size
};

/*! Formats of the kinds with frames, indexed by kind. */
CVERT_CONSTANT uint32_t numKindFormats = 3u;
CVERT_CONSTANT KindFormat kindFormats[numKindFormats] = {
    /* cGRID: leaves are 2 x 2 quads, as in GRID; loads of 4 floats may read past the last row, which is padded by 3 */
    {1u, 0u, 0u, 12u, 12u},
    /* cVOXEL */
    {0u, 0u, 0u, 0u, 0u},
    /* cLEAF: 2 x 2 leaves share 9 heights of 7 bits, 8 bytes; a single quad is split into four leaves */
    {0u, 1u, 8u, 0u, 0u}};

CBVH_END

#ifndef VULKAN
#include "../../../include/embree3/rtcore_compression.h"

CBVH_BEGIN

enum class Kind : uint32_t {
  CGRID = kindGrid,
  CVOXEL = kindVoxel,
  CLEAF = kindLeaf,
  CVERT = kindVert,
  CTILE = kindTile
};

struct KindDescription {
  Kind kind;
  const char* key;    //!< "cbvh.KEY" in device strings, KEY in EMBREE_CBVH, "cKEY" in command lines
  const char* name;   //!< name in messages
  bool alignsToLimit; //!< frames align to the corners on the limit surface, otherwise to displaced ones
  bool supportsHoles; //!< leaves can leave out a quad
  bool hasThickness;  //!< leaves are inexact, with a bound on their thickness

  bool hasFrame() const { return ((framedKinds >> uint32_t(kind)) & 1u) != 0u; }
  RTCCompression compression() const { return RTCCompression(RTC_COMPRESSION_CGRID + uint32_t(kind)); }
};

/*! Only cLEAF aligns frames to the limit surface, along whose normals heights are stored best. Boxes of other kinds are
 *  tightest if frames align to the displaced surface. */
// clang-format off
static constexpr KindDescription kindDescriptions[] = {
#if !defined(EMBREE_CBVH_NO_PAPER)
  { Kind::CGRID,  "grid",  "cGRID",  false, true,  false },
  { Kind::CVOXEL, "voxel", "cVOXEL", false, false, true  },
  { Kind::CLEAF,  "leaf",  "cLEAF",  true,  true,  true  },
#endif
  { Kind::CVERT,  "vert",  "cVERT",  false, true,  false },
  { Kind::CTILE,  "tile",  "cTILE",  false, true,  false }
};
// clang-format on
static constexpr uint32_t numKinds = sizeof(kindDescriptions) / sizeof(kindDescriptions[0]);

static_assert(framedKinds < (1u << maxFramedKinds), "headers of blocks with frames have 4 bits for the kind");
static_assert(RTC_COMPRESSION_CVOXEL - RTC_COMPRESSION_CGRID == kindVoxel,
              "a value of RTCCompression follows from the kind");
static_assert(RTC_COMPRESSION_CLEAF - RTC_COMPRESSION_CGRID == kindLeaf,
              "a value of RTCCompression follows from the kind");
static_assert(RTC_COMPRESSION_CVERT - RTC_COMPRESSION_CGRID == kindVert,
              "a value of RTCCompression follows from the kind");
static_assert(RTC_COMPRESSION_CTILE - RTC_COMPRESSION_CGRID == kindTile,
              "a value of RTCCompression follows from the kind");

/*! True for cVERT and cTILE, which have the same vertices. */
inline bool isExact(RTCCompression compression) {
  return compression == RTC_COMPRESSION_CVERT || compression == RTC_COMPRESSION_CTILE;
}

/*! Returns the entry of kindDescriptions for a kind, which must have one. */
inline const KindDescription& descriptionOf(Kind kind) {
  uint32_t row = 0;
  while (kindDescriptions[row].kind != kind) row++;
  return kindDescriptions[row];
}

/*! Finds the kind of an RTCCompression. Returns false if this library does not have it. */
inline bool findKind(int compression, Kind& kind) {
  for (const KindDescription& description : kindDescriptions)
    if (description.compression() == compression) {
      kind = description.kind;
      return true;
    }
  return false;
}

/*! Returns the compression of a geometry in a file, or cVERT if this library was built without its kind. Loading then
 *  fails, unless all blocks are cVERT because all faces are fallback faces. */
inline RTCCompression compressionOfLoaded(uint32_t compression) {
  Kind kind;
  return findKind(int(compression), kind) ? RTCCompression(compression) : RTC_COMPRESSION_CVERT;
}

CBVH_END
#endif

#endif
