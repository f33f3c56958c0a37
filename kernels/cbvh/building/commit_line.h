// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The line that the commit of a scene prints at verbosity 1, or if EMBREE_CBVH contains "verbose": what is compressed,
 * its memory, and what is not compressed and why. Static and moving surfaces have a line each. If only one is printed,
 * it lists the uncompressed geometries of both. For users who cannot change the program. */

#include "../base/build_statistics.h"
#include "../base/kinds.h"
#include "../embree/scene.h"
#include <iomanip>
#include <locale>
#include <map>
#include <sstream>

namespace embree::isa {
/*! "face", "grid", "quad" or "triangle". */
inline const char* primitiveName(const CompressibleGeometry* geometry) {
  switch (geometry->ownType) {
  case Geometry::GTY_GRID_MESH: return "grid";
  case Geometry::GTY_QUAD_MESH: return "quad";
  case Geometry::GTY_TRIANGLE_MESH: return "triangle";
  default: return "face";
  }
}

/*! For example ", beginning with face 7 (vertex 12)"; empty if the first primitive is not known. */
inline std::string firstInvalidText(const cbvh::SurfaceStatistics& statistics, const std::string& primitive) {
  if (statistics.firstInvalidFace == std::numeric_limits<size_t>::max()) return "";
  const cbvh::InvalidVertex& vertex = statistics.firstInvalidVertex;
  return ", beginning with " + primitive + " " + std::to_string(statistics.firstInvalidFace) +
         (vertex.vertex == ~0u ? "" : " (vertex " + std::to_string(vertex.vertex) + ")");
}

class CommitLine {
public:
  void addCompressed(const CompressibleGeometry* geometry, unsigned geomID, cbvh::Kind kind,
                     const cbvh::SurfaceStatistics& statistics) {
    if (statistics.sums.numInvalidQuads && firstInvalid.empty())
      firstInvalid = firstInvalidText(statistics, primitiveName(geometry)) + " of geometry " + std::to_string(geomID);
    Compressed& entryOfKind = compressed[std::make_pair(std::string(namesOf(geometry).geometry), kind)];
    entryOfKind.names = namesOf(geometry);
    entryOfKind.count++;
    all.add(statistics);
  }

  void addUncompressed(const CompressibleGeometry* geometry) {
    if (geometry->ownType == Geometry::GTY_SUBDIV_MESH && !geometry->surface.rejectionReason) notRequested++;
    else if (geometry->surface.rejectionReason && *geometry->surface.rejectionReason)
      rejected[{namesOf(geometry).primitives, geometry->surface.rejectionReason}] += geometry->size();
  }

  /*! Counts a surface that could have another form. bytes: now. otherBytes: in that form, an estimate. */
  void addOtherForm(bool hasTiles, size_t bytes, size_t otherBytes) {
    (hasTiles ? tiles : blocks) += bytes;
    (hasTiles ? tilesAsBlocks : blocksAsTiles) += otherBytes;
  }

  /*! treeBytes: size of the scene's own tree. scene: only inputBytes and cacheBytesPerThread are used. */
  std::string text(size_t treeBytes, const cbvh::CompressionStatistics& scene) const {
    const cbvh::CompressionStatistics& sums = all.sums;
    std::ostringstream line;
    line.imbue(std::locale::classic());
    const size_t bytes = treeBytes + sums.allBytes();
    line << "compression: " << geometries() << ": " << sums.numQuads + sums.numUncompressedQuads << " quads in "
         << mebibytes(bytes) << " MiB, Embree would use about " << mebibytes(all.bytesInEmbree) << " MiB";
    if (tiles) line << ", as cVERT about " << mebibytes(bytes - tiles + tilesAsBlocks) << " MiB";
    if (blocks) line << ", as cTILE about " << mebibytes(bytes - blocks + blocksAsTiles) << " MiB";
    if (sums.maxVertexDeviation > 0)
      line << "; vertices move by up to " << std::setprecision(3) << sums.maxVertexDeviation;
    if (scene.inputBytes) line << "; buffers that stay: " << mebibytes(scene.inputBytes) << " MiB";
    if (scene.cacheBytesPerThread)
      line << "; caches: up to " << mebibytes(scene.cacheBytesPerThread) << " MiB per thread";
    if (sums.numInvalidQuads)
      line << "; left out: " << sums.numInvalidQuads << " quads, because a vertex is not finite or does not exist"
           << firstInvalid;
    const char* separator = "; not compressed: ";
    auto add = [&](size_t n, const std::string& what) {
      if (n) {
        line << separator << n << what;
        separator = ", ";
      }
    };
    add(notRequested, notRequested == 1 ? " subdivision surface that does not ask for it"
                                        : " subdivision surfaces that do not ask for it");
    add(all.highRateQuads, " quads with too high edge rates");
    add(all.framelessQuadsInGrid, " quads of blocks without a good frame");
    add(sums.numUnsupportedFaces, " faces that Embree does not support");
    for (const auto& entry : rejected) add(entry.second, " " + entry.first.first + " that " + entry.first.second);
    return line.str();
  }

private:
  static std::string mebibytes(size_t bytes) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << std::fixed << std::setprecision(bytes < (size_t(10) << 20) ? 2 : 1) << double(bytes) / (1 << 20);
    return text.str();
  }

  struct Names {
    const char *geometry, *geometries, *primitives;
  };

  static Names namesOf(const CompressibleGeometry* geometry) {
    switch (geometry->ownType) {
    case Geometry::GTY_GRID_MESH: return {"grid geometry", "grid geometries", "grids"};
    case Geometry::GTY_QUAD_MESH: return {"quad mesh", "quad meshes", "quads"};
    case Geometry::GTY_TRIANGLE_MESH: return {"triangle mesh", "triangle meshes", "triangles"};
    default: return {"subdivision surface", "subdivision surfaces", "faces"};
    }
  }

  /*! For example "1 quad mesh as cVERT, 2 subdivision surfaces as cVERT". */
  std::string geometries() const {
    std::string text;
    for (const auto& entry : compressed) {
      const Compressed& kindEntry = entry.second;
      text += (text.empty() ? "" : ", ") + std::to_string(kindEntry.count) + " " +
              (kindEntry.count == 1 ? kindEntry.names.geometry : kindEntry.names.geometries) + " as " +
              cbvh::descriptionOf(entry.first.second).name;
    }
    return text.empty() ? "nothing" : text;
  }

  struct Compressed {
    Names names;
    size_t count = 0;
  };
  std::map<std::pair<std::string, cbvh::Kind>, Compressed> compressed; //!< by type and kind
  cbvh::BuildStatistics all;                                           //!< sum over `compressed`
  /*! Uncompressed primitives, by type and reason. */
  std::map<std::pair<std::string, std::string>, size_t> rejected;
  size_t tiles = 0, tilesAsBlocks = 0, blocks = 0, blocksAsTiles = 0; //!< bytes of surfaces with another form
  std::string firstInvalid;                                           //!< of the first geometry that has some
  size_t notRequested = 0;                                            //!< subdivision surfaces without a request
};
} // namespace embree::isa
