// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The triangles of a mesh that are in no grid. building/irregular_blocks.h stores them in mesh blocks. Vertices on no
 * grid's border are on one lattice, or on finer ones if it would flip triangles. These exceptions are found per time
 * step, before any block is encoded, so that blocks agree on shared vertices. */

#include "../base/resize_to_fit.h"
#include "../base/tasks.h"
#include "../../cvert/encoder/mesh_partition.h"
#include "../../cvert/encoder/mesh_lattice.h"
#include "border_lattices.h"
#include "embree_bytes.h"
#include "welded_vertices.h"
#include <memory>

namespace embree::isa {
/*! The triangles of a mesh, by number. Triangle i of a triangle mesh is primitive i. Triangles 2 i and 2 i + 1 of a
 *  quad mesh are the halves of quad i, split as in Embree. The mesh must outlive the object. */
class TrianglesOfMesh {
public:
  explicit TrianglesOfMesh(const TriangleMesh* mesh)
    : trianglesPerPrimitive(1),
      numPrimitives(mesh->triangles.size()),
      numVertices(mesh->numVertices()),
      steps(&mesh->vertices[0]),
      numSteps(mesh->numTimeSteps),
      indices(mesh->triangles.getPtr()),
      stride(mesh->triangles.getStride()) {}
  explicit TrianglesOfMesh(const QuadMesh* mesh)
    : trianglesPerPrimitive(2),
      numPrimitives(mesh->quads.size()),
      numVertices(mesh->numVertices()),
      steps(&mesh->vertices[0]),
      numSteps(mesh->numTimeSteps),
      indices(mesh->quads.getPtr()),
      stride(mesh->quads.getStride()) {}

  const uint32_t trianglesPerPrimitive;
  const size_t numPrimitives;

  bool areHalvesOfQuads() const { return trianglesPerPrimitive == 2; }

  /*! i: first (0) or second (1) triangle of a primitive. */
  uint32_t triangleOf(uint32_t primitive, uint32_t i) const { return (primitive << (trianglesPerPrimitive - 1)) + i; }

  /*! Sets pointers to the corners at the first step, in the order of the triangle or of Embree's half of the quad.
   *  Returns false if Embree skips the primitive: an index is out of range, or a vertex is not finite at a step. */
  bool corners(size_t triangle, const float* out[3]) const {
    unsigned vertices[3];
    return corners(triangle, out, vertices);
  }

  /*! Also sets `vertices` to the indices of the corners in the vertex buffer. */
  bool corners(size_t triangle, const float* out[3], unsigned vertices[3]) const {
    static const uint8_t ofQuad[2][3] = {{0, 1, 3}, {2, 3, 1}};
    const uint32_t n = areHalvesOfQuads() ? 4 : 3;
    unsigned v[4];
    memcpy(v, indices + (triangle >> (trianglesPerPrimitive - 1)) * stride, n * sizeof(unsigned));
    const float* p[4];
    for (uint32_t i = 0; i < n; i++) {
      if (v[i] >= numVertices) return false;
      p[i] = vertex(0, v[i]);
      if (!cbvh::isFinite(p[i])) return false;
      for (unsigned step = 1; step < numSteps; step++)
        if (!cbvh::isFinite(vertex(step, v[i]))) return false;
    }
    for (int c = 0; c < 3; c++) {
      const int i = areHalvesOfQuads() ? ofQuad[triangle & 1][c] : c;
      out[c] = p[i];
      vertices[c] = v[i];
    }
    return true;
  }

  const float* vertex(unsigned step, size_t i) const { return (const float*)steps[step].getPtr(i); }

  /*! As WeldedVertices::find. */
  std::shared_ptr<const WeldedVertices> weld() const { return WeldedVertices::find(steps, numSteps, numVertices); }

private:
  const size_t numVertices;
  const BufferView<Vec3fa>* const steps;
  const unsigned numSteps;
  const char* const indices;
  const size_t stride;
};

/*! Border vertices of grids as they are stored. Triangles that share them use the same floats, so that there are no
 *  gaps between grids and mesh blocks. */
class StoredBorders {
public:
  /*! Sets out to the stored position of a vertex. Returns false if the vertex is on no border, or the geometry is
   *  lossless. vertex: index in the buffer; its position must be finite. */
  virtual bool find(size_t vertex, float out[3]) const = 0;

protected:
  ~StoredBorders() {}
};

/*! After prepare(), const members are thread-safe. Triangles and primitives that they receive must be valid, see
 *  TrianglesOfMesh::corners(). */
class IrregularTriangles {
public:
  /*! primitives: ascending; null for the whole mesh. plan and primitives must outlive this object. */
  IrregularTriangles(const TrianglesOfMesh& mesh, const mvector<unsigned>* primitives, const CompressionPlan& plan,
                     Device* device)
    : mesh(mesh),
      primitives(primitives),
      plan(plan),
      device(device),
      centers(device, 0) {}

  /*! Includes invalid primitives. */
  size_t numPrimitives() const { return primitives ? primitives->size() : mesh.numPrimitives; }
  size_t numTriangles() const { return numPrimitives() * mesh.trianglesPerPrimitive; }

  size_t bytesInEmbree() const {
    return numPrimitives() * (mesh.areHalvesOfQuads() ? bytesOfQuadInEmbree(plan.numTimeSteps)
                                                      : bytesOfTriangleInEmbree(plan.numTimeSteps));
  }

  /*! Chooses the lattices, and finds the primitives that a ray can hit. borders: of the mesh's grids, or null;
   *  snapCorners() reads them. */
  template<typename Progress>
  void prepare(const StoredBorders* borders, const Progress& progress) {
    this->borders = borders;
    double movedEdge = 0;
    int exponent = chooseExponent(movedEdge);
    while (flipsMost(exponent)) exponent = max(exponent - cbvh::MeshLattice::finerBits, cbvh::losslessExponent);
    spacingOfLattice = cbvh::WorldLattice(exponent).spacing;
    if (plan.settings.maxError > 0) warnIfCoarse(device, spacingOfLattice, movedEdge);
    for (unsigned step = 0; step < plan.numTimeSteps; step++) lattices.emplace_back(new cbvh::MeshLattice(exponent));
    if (plan.moves()) welded = mesh.weld();
    cbvh::resizeToFit(centers, numPrimitives());
    const size_t tasks = (numPrimitives() + perTask - 1) / perTask;
    std::vector<TaskResult> found(tasks);
    parallel_for(size_t(0), tasks, size_t(1), [&](const range<size_t>& r) {
      for (size_t task = r.begin(); task != r.end(); task++) findHittable(task, found[task]);
      progress();
    });
    size_t n = 0;
    for (size_t task = 0; task < tasks; task++) {
      if (n != task * perTask) std::copy_n(centers.begin() + task * perTask, found[task].count, centers.begin() + n);
      n += found[task].count;
      numInvalid += found[task].numInvalid;
    }
    centers.resize(n);
    refineUntilNoneFlips(found, progress);
  }

  void release() {
    centers.clear();
    lattices.clear();
    welded.reset();
  }

  /*! For meshes with one time step. Sets out to the stored corners of a triangle; corners on the border of a grid
   *  are the grid's. Returns the squared distance that the farthest corner moved. */
  double snapCorners(uint32_t triangle, float out[3][3]) const {
    const float* p[3];
    unsigned vertices[3];
    mesh.corners(triangle, p, vertices);
    double maxSquare = 0;
    for (int c = 0; c < 3; c++) {
      if (!borders || !borders->find(vertices[c], out[c])) lattices[0]->snap(p[c], out[c]);
      double square = 0;
      for (int k = 0; k < 3; k++) {
        const double d = double(out[c][k]) - p[c][k];
        square += d * d;
      }
      maxSquare = max(maxSquare, square);
    }
    return maxSquare;
  }

  /*! For moving meshes. Sets the corners' IDs: for each, the lowest vertex that is equal to it at all steps. */
  void cornerIDs(uint32_t triangle, uint32_t out[3]) const {
    const float* p[3];
    unsigned vertices[3];
    mesh.corners(triangle, p, vertices);
    for (int c = 0; c < 3; c++) out[c] = welded ? (*welded)[vertices[c]] : vertices[c];
  }

  /*! Sets out to the stored position of a vertex. id: see cornerIDs(). Returns the squared distance that it
   *  moved. */
  double snapVertex(unsigned step, uint32_t id, float out[3]) const {
    const float* const p = mesh.vertex(step, id);
    lattices[step]->snap(p, out);
    double square = 0;
    for (int k = 0; k < 3; k++) {
      const double d = double(out[k]) - p[k];
      square += d * d;
    }
    return square;
  }

  /*! True if two corners of a moving triangle are equal at all steps, so that no ray can hit it. Without area at
   *  some steps, it could still have area between them. */
  bool haveEqualCorners(uint32_t triangle) const {
    uint32_t ids[3];
    cornerIDs(triangle, ids);
    return ids[0] == ids[1] || ids[1] == ids[2] || ids[2] == ids[0];
  }

  /*! Bounds of a primitive's vertices at the first step, before they are snapped. */
  void bounds(uint32_t primitive, float lower[3], float upper[3]) const {
    const float* p[6];
    for (uint32_t i = 0; i < mesh.trianglesPerPrimitive; i++) mesh.corners(mesh.triangleOf(primitive, i), p + 3 * i);
    for (int k = 0; k < 3; k++) {
      lower[k] = upper[k] = p[0][k];
      for (uint32_t i = 1; i < 3 * mesh.trianglesPerPrimitive; i++) {
        lower[k] = min(lower[k], p[i][k]);
        upper[k] = max(upper[k], p[i][k]);
      }
    }
  }

  float spacing() const { return spacingOfLattice; }

  const TrianglesOfMesh mesh;
  size_t numInvalid = 0; //!< primitives with an invalid index or vertex

private:
  static const size_t perTask = 1 << 14, sampledPrimitives = 1 << 16;

  struct TaskResult {
    size_t count = 0, numInvalid = 0;
    std::vector<uint32_t> fragile; //!< triangles that the lattice may flip, at any step
    std::vector<uint32_t> flipped; //!< those that it flips with its exceptions so far
  };

  uint32_t primitiveAt(size_t i) const { return primitives ? (*primitives)[i] : uint32_t(i); }

  /*! Chooses the lattice's exponent from the edges of a sample of triangles. Sets movedEdge to their median, or to 0 if
   *  the lattice does not move them. */
  int chooseExponent(double& movedEdge) const {
    LatticeChoice choice(cbvh::spacingPerMeshEdge);
    const size_t stride = max(numPrimitives() / sampledPrimitives, size_t(1));
    for (size_t i = 0; i < numPrimitives(); i += stride) {
      const float* p[3];
      unsigned vertices[3];
      if (!mesh.corners(mesh.triangleOf(primitiveAt(i), 0), p, vertices)) continue;
      for (unsigned step = 0; step < plan.numTimeSteps; step++) {
        float line[4][3];
        for (int c = 0; c < 4; c++) memcpy(line[c], mesh.vertex(step, vertices[c % 3]), sizeof(line[c]));
        choice.addLine(true, line, 4);
      }
    }
    if (plan.settings.maxPixelError > 0) choice.extendBounds(boundsOfAll());
    const int exponent = choice.exponent(plan, 0.0);
    movedEdge = choice.areOnLattice(exponent) ? 0 : choice.medianEdge();
    return exponent;
  }

  /*! Bounds of the valid primitives at all steps. */
  cbvh::WorldBounds boundsOfAll() const {
    return reduceRanges(
        numPrimitives(), perTask, cbvh::WorldBounds(),
        [&](const range<size_t>& r) {
          cbvh::WorldBounds bounds;
          for (size_t i = r.begin(); i != r.end(); i++)
            for (uint32_t k = 0; k < mesh.trianglesPerPrimitive; k++) {
              const float* p[3];
              unsigned vertices[3];
              if (!mesh.corners(mesh.triangleOf(primitiveAt(i), k), p, vertices)) break;
              for (unsigned step = 0; step < plan.numTimeSteps; step++)
                for (unsigned v : vertices) {
                  const float* const at = mesh.vertex(step, v);
                  bounds.extend(at[0], at[1], at[2]);
                }
            }
          return bounds;
        },
        [](const cbvh::WorldBounds& a, const cbvh::WorldBounds& b) {
          cbvh::WorldBounds both = a;
          both.extend(b);
          return both;
        });
  }

  /*! True if a lattice flips more than half of a sample of triangles: finding exceptions would take longer than the
   *  rest of the build, so prepare() uses a finer lattice for all. Blocks hardly grow: a block with exceptions
   *  has the finest spacing of its vertices anyway. */
  bool flipsMost(int exponent) const {
    const cbvh::MeshLattice lattice(exponent);
    const size_t samples = min(numPrimitives(), size_t(1024));
    size_t flipped = 0;
    for (size_t i = 0; i < samples; i++) {
      const float* p[3];
      flipped += mesh.corners(mesh.triangleOf(primitiveAt(i * numPrimitives() / samples), 0), p) &&
                 lattice.flips(p[0], p[1], p[2]);
    }
    return 2 * flipped > samples;
  }

  /*! Finds the primitives of a task that rays can hit. */
  void findHittable(size_t task, TaskResult& out) {
    const size_t begin = task * perTask, end = min(begin + perTask, numPrimitives());
    for (size_t i = begin; i < end; i++) {
      const uint32_t primitive = primitiveAt(i);
      bool isValid = true, canBeHit = false;
      for (uint32_t k = 0; k < mesh.trianglesPerPrimitive && isValid; k++) {
        const uint32_t triangle = mesh.triangleOf(primitive, k);
        const float* p[3];
        unsigned vertices[3];
        isValid = mesh.corners(triangle, p, vertices);
        if (!isValid) continue;
        bool isRobust = lattices[0]->isRobust(p[0], p[1], p[2]);
        if (plan.moves()) {
          if (haveEqualCorners(triangle)) continue;
          for (unsigned step = 1; step < plan.numTimeSteps && isRobust; step++) isRobust = isRobustAt(step, vertices);
        } else if (!isRobust && cbvh::MeshLattice::isDegenerate(p[0], p[1], p[2])) continue;
        canBeHit = true;
        if (!isRobust) out.fragile.push_back(triangle);
      }
      if (!isValid) out.numInvalid++;
      if (!isValid || !canBeHit) continue;
      cbvh::MeshCenter& center = centers[begin + out.count++];
      float lower[3], upper[3];
      bounds(primitive, lower, upper);
      for (int k = 0; k < 3; k++) center.at[k] = 0.5f * (lower[k] + upper[k]);
      center.index = primitive;
    }
  }

  bool isRobustAt(unsigned step, const unsigned v[3]) const {
    return lattices[step]->isRobust(mesh.vertex(step, v[0]), mesh.vertex(step, v[1]), mesh.vertex(step, v[2]));
  }

  /*! Refines lattices until they flip no triangle: a vertex on a finer lattice can flip other triangles. One thread
   *  changes the lattices, in a fixed order: results do not depend on threads. */
  template<typename Progress>
  void refineUntilNoneFlips(std::vector<TaskResult>& found, const Progress& progress) {
    for (bool changed = true; changed;) {
      parallel_for(size_t(0), found.size(), size_t(1), [&](const range<size_t>& r) {
        for (size_t task = r.begin(); task != r.end(); task++) findFlipped(found[task]);
        progress();
      });
      changed = false;
      for (const TaskResult& task : found)
        for (uint32_t triangle : task.flipped)
          forEachStep(triangle, [&](cbvh::MeshLattice& lattice, const float* a, const float* b, const float* c) {
            changed |= lattice.refine(a, b, c);
          });
    }
  }

  void findFlipped(TaskResult& task) const {
    task.flipped.clear();
    for (uint32_t triangle : task.fragile) {
      bool isFlipped = false;
      forEachStep(triangle, [&](const cbvh::MeshLattice& lattice, const float* a, const float* b, const float* c) {
        isFlipped = isFlipped || lattice.flips(a, b, c);
      });
      if (isFlipped) task.flipped.push_back(triangle);
    }
  }

  /*! Calls onStep(lattice,a,b,c) with the corners at each step. */
  template<typename OnStep>
  void forEachStep(uint32_t triangle, const OnStep& onStep) const {
    const float* p[3];
    unsigned v[3];
    mesh.corners(triangle, p, v);
    for (unsigned step = 0; step < plan.numTimeSteps; step++)
      onStep(*lattices[step], mesh.vertex(step, v[0]), mesh.vertex(step, v[1]), mesh.vertex(step, v[2]));
  }

  const mvector<unsigned>* const primitives;
  const CompressionPlan& plan;
  Device* const device;
  const StoredBorders* borders = nullptr;
  std::vector<std::unique_ptr<cbvh::MeshLattice>> lattices; //!< by step
  std::shared_ptr<const WeldedVertices> welded;             //!< of a moving mesh; null if all vertices differ
  float spacingOfLattice = 0.0f;

public:
  /*! Primitives that can be hit, set by prepare(), with the centers of their bounds. Users may reorder them. */
  mvector<cbvh::MeshCenter> centers;
};
} // namespace embree::isa
