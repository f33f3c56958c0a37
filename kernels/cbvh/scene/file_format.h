// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Layout of files of compressed surfaces, specified in docs/formats/file.md. A file contains a header, then the tree and
 * the blocks of each geometry, then a directory of the geometries. Offsets are relative to the start of the file; numbers
 * are little-endian. A file contains no addresses, so it is traced as it lies on disk. */

#include "../base/surface_statistics.h"
#include "../framed/block.h"
#include "../vert/format.h"
#include <cstddef>
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! Version of the layout that this header and docs/formats/file.md describe; blocks have versions of their own */
    static const uint32_t fileVersion = 1;
    static const char fileMagic[8] = { 'c','b','v','h','\r','\n','\x1a','\0' }; // which transfers as text spoil
    static const uint32_t fileByteOrder = 0x01020304u;

    /*! parts begin at multiples of this, so that each has pages of its own */
    static const uint64_t filePage = 4096;

    /*! There are at least that many bytes behind the blocks of a geometry, as decoders read behind their end. */
    static const uint64_t fileReadBehind = 64;

    struct FileHeader
    {
      char magic[8];
      uint32_t byteOrder, version;           //!< fileByteOrder, fileVersion
      uint32_t vertVersion, framedVersion;   //!< of the blocks: vertFormatVersion, formatVersion
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

    struct FileGeometry
    {
      uint64_t tree, treeBytes, blocks, blockBytes;
      uint32_t treeChecksum, blocksChecksum;
      uint32_t form, source;
      uint32_t compression;                  //!< RTCCompression
      uint32_t surface;                      //!< number that its blocks have, bit 31 of surfaces that move included
      uint32_t numPrimitives, numTimeSteps;
      float begin, end;                      //!< times of the first step and of the last
      float lower[3], upper[3];              //!< of all that a ray may hit; lower is above upper if that is nothing
      uint64_t numBlocks;
      float measures[4];
      uint64_t counts[23];                   //!< statistics: forEachCount and forEachMeasure have their order
      uint64_t reserved[2];
    };
    static_assert(sizeof(FileGeometry) == 320,"record of a geometry");

    /*! a child: what it is in the lower 4 bits, and above them, times 16, where it is from the tree's or the blocks' start */
    enum FileChild : uint64_t { FILE_NONE = 0, FILE_NODE = 1, FILE_FRAMED = 2, FILE_VERT = 3, FILE_MOVING_VERT = 4, FILE_CHILD_MASK = 15 };

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

    /*! CRC-32C, as of iSCSI. before: of the bytes before; isPortable: without an instruction for it */
    uint32_t fileChecksum (const void* data, size_t bytes, uint32_t before = 0, bool isPortable = false);

    /*! Calls closure(count) for the counts of a surface's statistics, in the order of FileGeometry::counts. */
    template<typename Statistics, typename Closure>
    void forEachCount (Statistics& s, const Closure& closure)
    {
      closure(s.sums.topLevelBytes); closure(s.sums.frameBytes); closure(s.sums.nodeBytes); closure(s.sums.leafBytes); closure(s.sums.gridBytes);
      closure(s.sums.numBlocks); closure(s.sums.numQuads); closure(s.sums.numGridQuads); closure(s.sums.numInvalidQuads); closure(s.sums.numAffineBlocks);
      closure(s.sums.numSolidLeaves); closure(s.sums.numRawBlocks); closure(s.sums.numExactQuads); closure(s.sums.numFlippedQuads);
      closure(s.sums.numMeshQuads); closure(s.sums.numLooseQuads); closure(s.sums.numMovingQuads); closure(s.sums.motionBytes);
      closure(s.highRateQuads); closure(s.refusedQuads); closure(s.refusedInGrid); closure(s.quadsForHoles); closure(s.bytesInEmbree);
    }
    template<typename Statistics, typename Closure>
    void forEachMeasure (Statistics& s, const Closure& closure)
    {
      closure(s.sums.maxLeafThickness); closure(s.sums.maxVertexSpacing); closure(s.sums.maxVertexDeviation); closure(s.sums.maxBorderGap);
    }

    /*! Statistics of a record. */
    inline SurfaceStatistics statisticsOf (const FileGeometry& record)
    {
      SurfaceStatistics statistics;
      size_t n = 0, m = 0;
      forEachCount(statistics,[&](size_t& count) { count = size_t(record.counts[n++]); });
      forEachMeasure(statistics,[&](float& measure) { measure = record.measures[m++]; });
      return statistics;
    }
    inline void setStatistics (FileGeometry& record, const SurfaceStatistics& statistics)
    {
      size_t n = 0, m = 0;
      forEachCount(statistics,[&](size_t count) { record.counts[n++] = count; });
      forEachMeasure(statistics,[&](float measure) { record.measures[m++] = measure; });
    }
  }
}
