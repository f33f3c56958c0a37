// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Layout of files of compressed surfaces (docs/formats/file.md): a header, each geometry's tree and blocks, and a
 * directory. Offsets are from the start of the file. Little-endian. */

#include "../format/block_type.h"
#include "../format/mesh_motion.h"
#include "checksum.h"
#include <cstddef>
#include <cstdint>

namespace cvert {
/*! Version of this layout. Blocks have their own versions. */
static const uint32_t fileVersion = 1;
/*! Contains line ends, so that transfers in text mode are detected. */
static const char fileMagic[8] = {'c', 'b', 'v', 'h', '\r', '\n', '\x1a', '\0'};
static const uint32_t fileByteOrder = 0x01020304u;

/*! Version of blocks with frames (the paper's representations), which the codec copies but does not decode. */
static const uint32_t fileFramedVersion = 1;

/*! Each geometry's tree and its first block begin at multiples of this, in bytes. */
static const uint64_t filePage = 4096;

/*! Bytes after the blocks of a geometry, at least: decoders may read some. */
static const uint64_t fileReadPadding = 64;

struct FileHeader {
  char magic[8];
  uint32_t byteOrder, version;         //!< fileByteOrder, fileVersion
  uint32_t vertVersion, framedVersion; //!< newest version of the file's cVERT and mesh blocks, fileFramedVersion
  uint32_t numGeometries, recordBytes; //!< sizeof(FileGeometry)
  uint64_t fileBytes, directory;       //!< size of the file, offset of the records of geometries
  uint32_t directoryChecksum;
  uint32_t key[2];   //!< of a resumable writer, lower half first; else 0
  uint32_t checksum; //!< of the bytes before it
};
static_assert(sizeof(FileHeader) == 64, "header of a file");

/*! Form of a geometry's tree: nodes, a list of blocks, or a list of moving blocks. */
enum FileForm : uint32_t { FILE_TREE = 0, FILE_LIST = 1, FILE_MOVING = 2 };

enum FileSource : uint32_t { FILE_CAGE = 0, FILE_GRIDS = 1, FILE_QUADS = 2, FILE_TRIANGLES = 3 };

/*! Same values as RTCCompression. */
enum FileCompression : uint32_t {
  FILE_COMPRESSION_GRID = 2,
  FILE_COMPRESSION_VOXEL = 3,
  FILE_COMPRESSION_LEAF = 4,
  FILE_COMPRESSION_VERT = 5
};

/*! Record of the directory. */
struct FileGeometry {
  uint64_t tree, treeBytes, blocks, blockBytes; //!< offsets and sizes
  uint32_t treeChecksum, blocksChecksum;
  uint32_t form, source;
  uint32_t compression; //!< FileCompression
  uint32_t surface;     //!< surface number of all blocks, see format/limits.h
  uint32_t numPrimitives, numTimeSteps;
  float begin, end;         //!< times of the first and last step
  float lower[3], upper[3]; //!< of everything that rays can hit; empty if lower > upper
  uint64_t numBlocks;
  float measures[4];   //!< statistics of the surface, optional; see docs/formats/file.md
  uint64_t counts[23]; //!< the same
  uint64_t reserved[2];
};
static_assert(sizeof(FileGeometry) == 320, "record of a geometry");

/*! Type of a child, in its lower 4 bits: FILE_NONE, FILE_NODE, or the BlockType of a block, plus 1 if it moves. The
 *  upper bits are its offset from the start of the tree or blocks, a multiple of 16. */
enum FileChild : uint64_t {
  FILE_NONE = 0,
  FILE_NODE = 1,
  FILE_FRAMED = FRAMED_BLOCK,
  FILE_VERT = VERT_BLOCK,
  FILE_MOVING_VERT = VERT_BLOCK + 1,
  FILE_MESH = MESH_BLOCK,
  FILE_MOVING_MESH = MESH_BLOCK + 1,
  FILE_CHILD_MASK = 15
};

inline FileChild fileChildOf(BlockType type, bool moves) { return FileChild(uint64_t(type) + moves); }

/*! moves: whether the geometry moves. The child must be a block of such a geometry, see isKnownBlock(). */
inline BlockType blockTypeOf(FileChild child, bool moves) { return BlockType(uint64_t(child) - moves); }

inline bool isMesh(FileChild type) { return type == FILE_MESH || type == FILE_MOVING_MESH; }

/*! Nodes and blocks are in depth-first order, first children first. */
struct FileNode {
  uint64_t children[4];
  float planes[3][2][4]; //!< boxes: [axis][lower, upper][child]; zeros for FILE_NONE
};
static_assert(sizeof(FileNode) == 128, "node of a file");

struct FileEntry //!< a block of a list; the bounds of moving blocks are 0
{
  float lower[3], upper[3];
  uint64_t child;
};
static_assert(sizeof(FileEntry) == 32, "entry of a file");
} // namespace cvert
