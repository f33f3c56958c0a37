// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A short example of a source of vertices (kernels/cbvh/surface/source.h): a unit sphere, made of the six faces of a
 * cube. Faces compute the vertices of a common edge from the same points of the cube, and all are on one lattice, so
 * there is nothing to prepare. */

#include "kernels/cbvh/surface/source.h"
#include "kernels/cbvh/exact/writer.h"
#include <cmath>

namespace embree::isa {
class SphereSource {
public:
  /*! the constructor argument of SourceBuilder */
  struct Mesh : public CompressibleGeometry {
    const unsigned quads; //!< along the edges of a face

    Mesh(Device* device, unsigned quads) : CompressibleGeometry(device, GTY_USER_GEOMETRY, 6, 1), quads(quads) {
      compression.compression = RTC_COMPRESSION_CVERT;
    }
  };

  typedef PatchVertices Scratch;
  static const bool isDeterministic = true;
  static const int exponent = -14; //!< of the lattice

  class Patch : public SurfacePatch {
  public:
    Patch(uint32_t surfaceNumber, unsigned face, unsigned n, Scratch& scratch) : scratch(scratch) {
      this->surfaceNumber = surfaceNumber;
      primID = face;
      corner[0] = corner[1] = 0;
      quads[0] = quads[1] = n;
      for (float& r : rates) r = float(n);
      rate = rates;
    }
    Patch(const Patch& other, Scratch& scratch) : Patch(other.surfaceNumber, other.primID, other.quads[0], scratch) {}

    PatchVertices& evaluate(unsigned, unsigned, const PatchPart& part, unsigned) {
      scratch.setSize(part);
      float(*out)[3] = scratch.displaced();
      for (unsigned y = part.y0; y <= part.y1; y++)
        for (unsigned x = part.x0; x <= part.x1; x++) evaluate(x, y, *out++);
      return scratch;
    }

    struct Side {
      const Patch& patch;
      int s;
      unsigned rate;

      SharedVertex operator[](unsigned k) const {
        float p[3];
        const unsigned along = s < 2 ? k : rate - k, across = s == 1 || s == 2 ? rate : 0;
        if (s % 2 == 0) patch.evaluate(along, across, p);
        else patch.evaluate(across, along, p);
        return SharedVertex(p, exponent);
      }
    };
    Side side(int s, unsigned) const { return Side{*this, s, quads[0]}; }
    int latticeExponent(unsigned) const { return exponent; }

  private:
    /*! Faces 0 to 2 are at the positive ends of the axes, 3 to 5 at the negative ends, where x and y are
     *  exchanged so that normals point outwards. */
    void evaluate(unsigned x, unsigned y, float p[3]) const {
      auto coordinate = [&](unsigned i) { return 2.0 * i / quads[0] - 1.0; };
      const int axis = int(primID % 3);
      double c[3];
      c[axis] = primID < 3 ? 1.0 : -1.0;
      c[(axis + 1) % 3] = coordinate(primID < 3 ? x : y);
      c[(axis + 2) % 3] = coordinate(primID < 3 ? y : x);
      const double length = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
      for (int k = 0; k < 3; k++) p[k] = float(c[k] / length);
    }

    Scratch& scratch;
    float rates[4];
  };

  SphereSource(const Mesh* mesh, const CompressionPlan& plan) : mesh(mesh), plan(plan) {}

  size_t size() const { return 6; }
  size_t estimateBlocks() const {
    const size_t n = cbvh::vertBlocksAlong(mesh->quads);
    return 6 * n * n;
  }
  size_t perTask(bool isSmall) const { return isSmall ? 6 : 1; }
  template<typename Progress> void prepare(size_t, const Progress&) {}
  void release() {}

  template<typename Closure>
  void forEachPatch(size_t face, Scratch& scratch, const Closure& closure) const {
    Patch patch(plan.surfaceNumber, unsigned(face), mesh->quads, scratch);
    closure(patch);
  }

  bool isInvalid(size_t, bool hasInvalidQuads) const { return hasInvalidQuads; }
  size_t quadsWithoutSurface(size_t) const { return 0; }
  cbvh::InvalidVertex invalidVertex(size_t) const { return cbvh::InvalidVertex(); }
  bool isUnsupported(size_t) const { return false; }
  size_t bytesInEmbree(const SurfacePatch&) const { return 0; }

  class Writer {
  public:
    Writer(const SphereSource& source, BlockStore& store, cbvh::BuildStatistics& statistics)
      : vert(source.plan, source.mesh->device, store, statistics) {}

    bool write(size_t, Patch& patch) {
      if (patch.quads[1] > VertWriter::rowsOfStrip(patch, 1)) return false;
      vert.write(patch, [](unsigned) { return (const float(*)[3]) nullptr; });
      return true;
    }

  private:
    VertWriter vert;
  };

private:
  const Mesh* mesh;
  const CompressionPlan& plan;
};
} // namespace embree::isa
