// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Layout of files of compressed surfaces, specified in docs/formats/file.md. A file contains a header, then the tree and
 * the blocks of each geometry, then a directory of the geometries. Offsets are relative to the start of the file; numbers
 * are little-endian. A file contains no addresses, so it is traced as it lies on disk. */

#include "../format/mesh_block.h"
#include "../format/motion.h"
#include "checksum.h"
#include <cstddef>
#include <cstdint>

namespace cvert
{
  /*! Version of the layout that this header and docs/formats/file.md describe; blocks have versions of their own */
  static const uint32_t fileVersion = 1;
  static const char fileMagic[8] = { 'c','b','v','h','\r','\n','\x1a','\0' }; // damaged by transfers in text mode
  static const uint32_t fileByteOrder = 0x01020304u;

  /*! Version of the blocks with frames that a file may contain. This library copies them and does not decode them. */
  static const uint32_t fileFramedVersion = 1;

  /*! parts begin at multiples of this, so that each has pages of its own */
  static const uint64_t filePage = 4096;

  /*! At least this many bytes follow the blocks of a geometry, because decoders read past the end of a block. */
  static const uint64_t fileReadBehind = 64;

  struct FileHeader
  {
    char magic[8];
    uint32_t byteOrder, version;           //!< fileByteOrder, fileVersion
    /*! Of the blocks: vertFormatVersion, or meshFormatVersion of a file with mesh blocks; fileFramedVersion */
    uint32_t vertVersion, framedVersion;
    uint32_t numGeometries, recordBytes;   //!< sizeof(FileGeometry)
    uint64_t fileBytes, directory;         //!< the size of all, and where the geometries' records are
    uint32_t directoryChecksum;
    uint32_t key[2];                       //!< of what a writer that goes on with the file makes it from, the lower half first; else 0
    uint32_t checksum;                     //!< of the bytes before it
  };
  static_assert(sizeof(FileHeader) == 64,"header of a file");

  /*! what the tree of a geometry is: nodes, or a list of few blocks, or of blocks that move */
  enum FileForm : uint32_t { FILE_TREE = 0, FILE_LIST = 1, FILE_MOVING = 2 };

  /*! what a geometry was made from */
  enum FileSource : uint32_t { FILE_CAGE = 0, FILE_GRIDS = 1, FILE_QUADS = 2, FILE_TRIANGLES = 3 };

  /*! how a geometry is stored; the values of RTCCompression */
  enum FileCompression : uint32_t { FILE_COMPRESSION_GRID = 2, FILE_COMPRESSION_VOXEL = 3, FILE_COMPRESSION_LEAF = 4, FILE_COMPRESSION_VERT = 5 };

  struct FileGeometry
  {
    uint64_t tree, treeBytes, blocks, blockBytes;
    uint32_t treeChecksum, blocksChecksum;
    uint32_t form, source;
    uint32_t compression;                  //!< FileCompression
    uint32_t surface;                      //!< number that its blocks have, bit 31 of surfaces that move included
    uint32_t numPrimitives, numTimeSteps;
    float begin, end;                      //!< times of the first step and of the last
    float lower[3], upper[3];              //!< of all that a ray may hit; lower is above upper if that is nothing
    uint64_t numBlocks;
    float measures[4];
    uint64_t counts[23];                   //!< statistics of the writer, as measures
    uint64_t reserved[2];
  };
  static_assert(sizeof(FileGeometry) == 320,"record of a geometry");

  /*! a child: what it is in the lower 4 bits, and above them, times 16, where it is from the tree's or the blocks' start */
  enum FileChild : uint64_t { FILE_NONE = 0, FILE_NODE = 1, FILE_FRAMED = 2, FILE_VERT = 3, FILE_MOVING_VERT = 4,
    FILE_MESH = 5, FILE_CHILD_MASK = 15 };

  /*! Nodes come in the order in which they are met from the root, first children first, and so do the blocks. */
  struct FileNode
  {
    uint64_t children[4];
    float planes[3][2][4];                 //!< by axis, lower and upper, of each child
  };
  static_assert(sizeof(FileNode) == 128,"node of a file");

  struct FileEntry                         //!< of a list; bounds of blocks that move are zeros
  {
    float lower[3], upper[3];
    uint64_t child;
  };
  static_assert(sizeof(FileEntry) == 32,"entry of a file");
}
