// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "stored_triangles.h"
#include "../base/block_validity.h"
#include "../base/closest_point_result.h"
#include "../embree/scene.h"
#include "../../cvert/decoder/decoded_mesh.h"
#include "../../cvert/decoder/mesh_tile_view.h"
#include "vertices_at_time.h"
#include "surface_blocks.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace embree::cbvh {
namespace {
/*! Calls closure(block) until it returns false. Then returns false, too. */
template<typename Closure>
bool forEachBlock(BVH4::NodeRef ref, const Closure& closure) {
  if (ref == BVH4::emptyNode) return true;
  if (!ref.isLeaf()) {
    for (size_t i = 0; i < 4; i++)
      if (!forEachBlock(ref.getAABBNode()->child(i), closure)) return false;
    return true;
  }
  size_t type;
  const void* block = ref.leaf(type);
  if (isBlock(type) && !isBlockValid(block, BlockType(type)))
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry's file is damaged: one of its blocks cannot be decoded");
  if (!isBlock(type) || (type == FRAMED_BLOCK && ((const Block*)block)->kind() != Kind::CGRID))
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the triangles of the geometry cannot be read: expected all of it "
                                                "to be stored as cVERT or cGRID");
  return closure(StoredBlock{block, BlockType(type)});
}

/*! Calls closure(block) until it returns false. Later blocks are not read. */
template<typename Closure>
void forEachBlock(const SurfaceBlocks& blocks, const Closure& closure) {
  for (const PrimRef& part : blocks.parts)
    if (!forEachBlock(BVH4::NodeRef(part.ID()), closure)) return;
  for (size_t block : blocks.moving)
    if (!forEachBlock(BVH4::NodeRef(block), closure)) return;
}

/*! Position of a block's quads in their patch, which determines parameters. Pairs of numbers are along u and
 *  v. */
struct BlockPosition {
  uint32_t patchQuads[2], first[2], quads[2];
  float corner[2];   //!< corner of the patch, in parameters of the face
  bool hasEdgeRates; //!< the block stores the rates of the patch's edges, which may be lower than patchQuads
  VertEdges edges;

  explicit BlockPosition(const VertHeader* block) : hasEdgeRates(hasEdges(block->info)), edges(edgesOf(block)) {
    patchQuads[0] = patchQuadsX(block->patchQuads);
    patchQuads[1] = patchQuadsY(block->patchQuads);
    first[0] = vertFirstX(block->region);
    first[1] = vertFirstY(block->region);
    quads[0] = vertQuadsX(block->region);
    quads[1] = vertQuadsY(block->region);
    corner[0] = 0.5f * float(vertCornerU(edges));
    corner[1] = 0.5f * float(vertCornerV(edges));
  }

  explicit BlockPosition(const Block* block) : hasEdgeRates(false), edges{0, 0} {
    patchQuads[0] = block->quadsX();
    patchQuads[1] = block->quadsY();
    first[0] = blockXOf(block->info) << block->height();
    first[1] = blockYOf(block->info) << block->height();
    quads[0] = quads[1] = 1u << block->height();
    corner[0] = 0.5f * float(cornerUOf(block->tiling));
    corner[1] = 0.5f * float(cornerVOf(block->tiling));
  }

  /*! Rate along a row (d = 0) or column (d = 1) of vertices. Returns the edge's stored rate if the row or column
   *  is an edge of the patch, otherwise patchQuads[d]. across: index of the row or column in the patch. */
  uint32_t rate(int d, uint32_t across) const {
    return hasEdgeRates && across == 0                   ? vertRate(edges, d == 0 ? 0 : 3)
           : hasEdgeRates && across == patchQuads[1 - d] ? vertRate(edges, d == 0 ? 2 : 1)
                                                         : patchQuads[d];
  }
};

/*! A decoded block of cVERT or cGRID whose quads belong to one primitive. */
struct ParametrizedBlock {
  const BlockPosition position;
  std::vector<std::array<float, 3>> vertices; //!< row by row
  std::vector<std::array<float, 2>> parameters;

  ParametrizedBlock(const VertHeader* block, const TraversalTime& time) : position(block) {
    setParameters();
    memcpy(vertices.data(), VerticesAtTime(block, time).vertices, vertices.size() * sizeof(vertices[0]));
  }

  /*! block: cGRID, which does not move. */
  ParametrizedBlock(const Block* block, const TraversalTime&) : position(block) {
    setParameters();
    const float* const planes = (const float*)block->leaves();
    for (size_t i = 0; i < vertices.size(); i++)
      for (int k = 0; k < 3; k++) vertices[i][k] = planes[k * vertices.size() + i];
  }

  /*! Calls closure(vertices, u, v) for the triangles of quads x0 to x1-1, y0 to y1-1 of the block. */
  template<typename Closure>
  void forEachTriangle(uint32_t x0, uint32_t x1, uint32_t y0, uint32_t y1, const Closure& closure) const {
    const uint32_t width = position.quads[0] + 1;
    for (uint32_t j = y0; j < y1; j++)
      for (uint32_t i = x0; i < x1; i++) {
        const uint32_t a = j * width + i;
        const uint32_t corners[2][3] = {{a, a + 1, a + width}, {a + width, a + 1, a + width + 1}};
        for (const uint32_t(&triangle)[3] : corners) {
          const float* p[3];
          float s[3], t[3];
          for (int c = 0; c < 3; c++) {
            p[c] = vertices[triangle[c]].data();
            s[c] = parameters[triangle[c]][0];
            t[c] = parameters[triangle[c]][1];
          }
          closure(p, s, t);
        }
      }
  }

private:
  /*! Also sets the number of vertices. */
  void setParameters() {
    const uint32_t width = position.quads[0] + 1, count = width * (position.quads[1] + 1);
    vertices.resize(count);
    parameters.resize(count);
    for (uint32_t i = 0; i < count; i++) {
      const uint32_t x = position.first[0] + i % width, y = position.first[1] + i / width;
      parameters[i][0] = position.corner[0] + vertParameter<float>(x, position.patchQuads[0], position.rate(0, y));
      parameters[i][1] = position.corner[1] + vertParameter<float>(y, position.patchQuads[1], position.rate(1, x));
    }
  }
};

template<typename Closure>
void forEachQuad(const VertHeader* block, const Closure& closure) {
  for (uint32_t y = 0; y < vertQuadsY(block->region); y++)
    for (uint32_t x = 0; x < vertQuadsX(block->region); x++) closure(x, y);
}

/*! False if the time is outside of a moving block's time range. */
bool isPresent(const StoredBlock& block, const TraversalTime& time) {
  switch (block.contents()) {
  case FRAMED_BLOCK: return true;
  case VERT_BLOCK:
  case TILE_BLOCK: return VerticesAtTime::isPresent(block.vert(), time);
  case MESH_BLOCK:
    return block.isMeshTile() ? MeshTileAtTime::isPresent(block.meshTile(), time)
                              : MeshAtTime::isPresent(block.mesh(), time);
  }
  return false;
}

/*! Calls closure(number, corners) for each triangle of a mesh tile. */
template<typename Closure>
void forEachTriangle(const MeshTileAtTime& tile, const Closure& closure) {
  const MeshTileView& view = tile.first;
  for (uint32_t g = 0; g < view.groups; g++)
    for (uint32_t t = 0; t < view.triangles(g); t++) {
      float corners[3][3];
      for (uint32_t c = 0; c < 3; c++) tile.vertex(g, view.corner(g, t, c), corners[c]);
      closure(view.number(g, t), corners);
    }
}

/*! Calls closure(number, corners) for each triangle of a mesh block or mesh tile. number: primitiveOfMesh() returns its
 *  primitive. */
template<typename Closure>
void forEachMeshTriangle(const StoredBlock& block, const TraversalTime& time, const Closure& closure) {
  if (block.isMeshTile()) return forEachTriangle(MeshTileAtTime(block.meshTile(), time), closure);
  const MeshAtTime mesh(block.mesh(), time);
  for (uint32_t g = 0; g < mesh.view.groups; g++) {
    const DecodedMeshGroup group = mesh.group(g);
    for (uint32_t t = 0; t < group.numTriangles; t++) {
      float corners[3][3];
      for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) corners[c][k] = group.corners[c][k][t];
      closure(group.numbers[t], corners);
    }
  }
}

/*! Calls closure(vertices, u, v) for the triangles of a primitive in a block with several, in the application's order.
 *  u, v: parameters of the vertices. */
template<typename Closure>
void forEachTriangleOf(const VertHeader* block, const TraversalTime& time, uint32_t primID, const Closure& closure) {
  const VerticesAtTime vertices(block, time);
  forEachQuad(block, [&](uint32_t x, uint32_t y) {
    const float* const corners[4] = {vertices.vertex(x, y), vertices.vertex(x + 1, y), vertices.vertex(x + 1, y + 1),
                                     vertices.vertex(x, y + 1)};
    for (bool isSecond : {false, true}) {
      const QuadPrimitive primitive = primitiveOfQuad(block, x, y, isSecond);
      const uint32_t numbering = primitive.numbering;
      if (primitive.primID != primID || (isSecond && isSingleTriangleNumbering(numbering))) continue;
      const float* p[3];
      float s[3] = {0, 1, 0}, t[3] = {0, 0, 1};
      for (uint32_t i = 0; i < 3; i++) {
        // `around` lists the corners in the order of primitiveParameters
        const uint32_t around[] = {isSecond ? 2u : 0u, isSecond ? 3u : 1u, isSecond ? 1u : 3u};
        p[i] = corners[around[(i + firstCornerOfTriangle(numbering, isSecond)) % 3]];
        if (!isTriangleNumbering(numbering) && isSecond) {
          s[i] = 1 - s[i];
          t[i] = 1 - t[i];
        }
      }
      closure(p, s, t);
    }
  });
}

template<typename Closure>
void forEachMeshTriangleOf(const StoredBlock& block, const TraversalTime& time, uint32_t primID,
                           const Closure& closure) {
  const uint32_t info = block.meshInfo();
  forEachMeshTriangle(block, time, [&](uint32_t number, const float(&corners)[3][3]) {
    if (primitiveOfMesh(info, number) != primID) return;
    const float* const p[3] = {corners[0], corners[1], corners[2]};
    const float first[2][3] = {{0, 1, 0}, {0, 0, 1}}, second[2][3] = {{1, 0, 1}, {1, 1, 0}};
    const float(&parameters)[2][3] = isSecondOfQuad(info, number) ? second : first;
    closure(p, parameters[0], parameters[1]);
  });
}

/*! The same for a block of one primitive. Header: VertHeader, or Block of cGRID. */
template<typename Header, typename Closure>
void forEachTriangleOf(const Header* block, const TraversalTime& time, const Closure& closure) {
  const ParametrizedBlock decoded(block, time);
  decoded.forEachTriangle(0, decoded.position.quads[0], 0, decoded.position.quads[1], closure);
}

/*! Finds the closest point of the triangles of a primitive. */
class ClosestSearch {
public:
  ClosestSearch(const TraversalTime& time, const float p[3], float radius, PointOnSurface& best)
    : time(time),
      p{p[0], p[1], p[2]},
      squared(double(radius) * radius),
      best(best) {}

  bool found = false;

  /*! block: must contain the primitive. */
  void searchBlock(const StoredBlock& block, uint32_t primID) {
    if (!isPresent(block, time)) return;
    auto consider = [&](const float* const corners[3], const float u[3], const float v[3]) {
      considerTriangle(corners, u, v, primID);
    };
    switch (block.contents()) {
    case FRAMED_BLOCK: forEachTriangleOf(block.framed(), time, consider); break;
    case VERT_BLOCK:
    case TILE_BLOCK:
      if (block.areQuadsPrimitives()) forEachTriangleOf(block.vert(), time, primID, consider);
      else forEachTriangleOf(block.vert(), time, consider);
      break;
    case MESH_BLOCK: forEachMeshTriangleOf(block, time, primID, consider); break;
    }
  }

private:
  void considerTriangle(const float* const corners[3], const float u[3], const float v[3], uint32_t primID) {
    WideTriangle<double> triangle;
    for (int k = 0; k < 3; k++)
      for (int c = 0; c < 3; c++) triangle.at[k][c] = corners[c][k];
    const PointOfTriangle at = closestPointOfTriangle(p, triangle.at);
    if (!(found ? at.squared < squared : at.squared <= squared)) return;
    found = true;
    squared = at.squared;
    setPoint(at, triangle, best);
    best.u = interpolated(at, u[0], u[1], u[2]);
    best.v = interpolated(at, v[0], v[1], v[2]);
    best.primID = primID;
    best.geomID = 0;
  }

  const TraversalTime time;
  const double p[3];
  double squared; //!< of the radius, or of the distance of `best`
  PointOnSurface& best;
};

/*! Finds the triangle of a hit by its primitive and parameters. As rounding can move these across an edge, it
 *  accepts triangles near (u,v). Among these, it selects the one whose normal or negative normal is closest to
 *  Ng, or the nearest one in barycentric coordinates if Ng is null. */
class Search {
public:
  Search(const TraversalTime& time, float u, float v, const float* Ng, StoredTriangle& best)
    : time(time),
      u(u),
      v(v),
      Ng(Ng),
      best(best) {}

  bool found() const { return hasBest; }

  /*! block: must contain the primitive. */
  void searchBlock(const StoredBlock& block, uint32_t primID) {
    if (!isPresent(block, time)) return;
    switch (block.contents()) {
    case FRAMED_BLOCK: searchByParameters(block.framed()); break;
    case VERT_BLOCK:
    case TILE_BLOCK:
      if (block.areQuadsPrimitives()) searchByPrimitive(block.vert(), primID);
      else searchByParameters(block.vert());
      break;
    case MESH_BLOCK: searchMesh(block, primID); break;
    }
  }

private:
  void searchByPrimitive(const VertHeader* block, uint32_t primID) {
    tolerance = roundingBound(u) + roundingBound(v);
    forEachTriangleOf(block, time, primID,
                      [&](const float* const p[3], const float s[3], const float t[3]) { addCandidate(p, s, t); });
  }

  void searchMesh(const StoredBlock& block, uint32_t primID) {
    tolerance = roundingBound(u) + roundingBound(v);
    forEachMeshTriangleOf(block, time, primID,
                          [&](const float* const p[3], const float s[3], const float t[3]) { addCandidate(p, s, t); });
  }

  /*! Header: VertHeader, or Block of cGRID. */
  template<typename Header>
  void searchByParameters(const Header* block) {
    const BlockPosition position(block);
    double x[2], margin[2];
    const float parameters[2] = {u, v};
    for (int d = 0; d < 2; d++) {
      x[d] = (double(parameters[d]) - position.corner[d]) * position.patchQuads[d] - position.first[d];
      margin[d] = roundingBound(parameters[d]) * position.patchQuads[d];
      /* vertices at edges of lower rates are stitched: parameters differ by up to one quad of these edges */
      if (position.hasEdgeRates)
        margin[d] +=
            double(position.patchQuads[d]) / std::min(vertRate(position.edges, d), vertRate(position.edges, d + 2));
      if (!(x[d] >= -margin[d] && x[d] <= position.quads[d] + margin[d])) return;
    }
    const ParametrizedBlock decoded(block, time);
    const uint32_t x0 = first(x[0] - margin[0]), x1 = last(x[0] + margin[0], position.quads[0]),
                   y0 = first(x[1] - margin[1]), y1 = last(x[1] + margin[1], position.quads[1]);
    tolerance = std::max(roundingBound(u) * position.patchQuads[0], roundingBound(v) * position.patchQuads[1]);
    decoded.forEachTriangle(
        x0, x1, y0, y1, [&](const float* const p[3], const float s[3], const float t[3]) { addCandidate(p, s, t); });
  }

  /*! Bound of a parameter's rounding error: a few roundings of values of at most 1 + |parameter|. */
  static double roundingBound(float parameter) {
    return 4.0 * std::numeric_limits<float>::epsilon() * (1.0 + std::fabs(double(parameter)));
  }

  static uint32_t first(double x) { return uint32_t(std::max(std::floor(x), 0.0)); }
  static uint32_t last(double x, uint32_t quads) { return uint32_t(std::min(std::floor(x) + 1.0, double(quads))); }

  /*! Stores a triangle in `best` if it is the best so far. vertexU, vertexV: parameters at its vertices. */
  void addCandidate(const float* const p[3], const float vertexU[3], const float vertexV[3]) {
    double s[3], t[3];
    for (int c = 0; c < 3; c++) {
      if (!(std::isfinite(p[c][0]) && std::isfinite(p[c][1]) && std::isfinite(p[c][2]))) return;
      s[c] = vertexU[c];
      t[c] = vertexV[c];
    }
    /* barycentric distance of the hit from the triangle */
    const double area = (s[1] - s[0]) * (t[2] - t[0]) - (s[2] - s[0]) * (t[1] - t[0]);
    if (area == 0) return; // the triangle is collapsed at a stitched edge
    const double w1 = ((u - s[0]) * (t[2] - t[0]) - (s[2] - s[0]) * (v - t[0])) / area,
                 w2 = ((s[1] - s[0]) * (v - t[0]) - (u - s[0]) * (t[1] - t[0])) / area;
    const double outside = std::max(0.0, -std::min(std::min(w1, w2), 1.0 - w1 - w2));
    if (outside > tolerance) return;
    const double cost = Ng ? squaredSine(p) : outside;
    if (hasBest && cost >= bestCost) return;
    hasBest = true;
    bestCost = cost;
    for (int c = 0; c < 3; c++) {
      memcpy(best.vertices[c], p[c], sizeof(best.vertices[c]));
      best.u[c] = vertexU[c];
      best.v[c] = vertexV[c];
    }
  }

  /*! Returns the squared sine of the angle between a triangle's normal and Ng, which ignores the sign of the
   *  normal. Returns 2 if either vector is zero. */
  double squaredSine(const float* const p[3]) const {
    double a[3], b[3], n[3], dot = 0, nn = 0, gg = 0;
    for (int k = 0; k < 3; k++) {
      a[k] = double(p[1][k]) - p[0][k];
      b[k] = double(p[2][k]) - p[0][k];
    }
    for (int k = 0; k < 3; k++) {
      n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
      dot += n[k] * Ng[k];
      nn += n[k] * n[k];
      gg += double(Ng[k]) * Ng[k];
    }
    return nn > 0 && gg > 0 ? 1.0 - dot * dot / (nn * gg) : 2.0;
  }

  const TraversalTime time;
  const float u, v;
  const float* const Ng;
  StoredTriangle& best;
  bool hasBest = false;
  double tolerance = 0, //!< largest accepted distance from a triangle, in barycentric coordinates
      bestCost = 0;
};
} // namespace

BlockIndex::BlockIndex(const SurfaceBlocks& surface) {
  blocks.reserve(surface.numPrimRefs);
  forEachBlock(surface, [&](const StoredBlock& block) {
    blocks.push_back(block);
    return true;
  });
  std::sort(blocks.begin(), blocks.end(),
            [](const StoredBlock& a, const StoredBlock& b) { return a.primID() < b.primID(); });
  size_t numTriangles = 0; // upper bound
  for (const StoredBlock& block : blocks) {
    switch (block.contents()) {
    case FRAMED_BLOCK: break;
    case VERT_BLOCK:
    case TILE_BLOCK:
      if (block.areQuadsPrimitives())
        numTriangles += 2 * vertQuadsX(block.vert()->region) * vertQuadsY(block.vert()->region);
      break;
    case MESH_BLOCK:
      numTriangles += meshTriangles(block.isMeshTile() ? block.meshTile()->counts : block.mesh()->counts);
      break;
    }
  }
  /* Primitive numbers of a file may be up to 2^32-2 in any block. So blockOf has no more bytes than pairs for all
   * triangles would have. */
  const size_t maxSize = 2 * numTriangles;
  auto add = [&](uint32_t primID, size_t i) {
    const uint32_t block = uint32_t(i);
    if (primID >= maxSize) {
      otherBlocks.emplace_back(primID, block);
      return;
    }
    if (primID >= blockOf.size())
      blockOf.resize(std::min(std::max(size_t(primID) + 1, 2 * blockOf.size()), maxSize), uint32_t(none));
    uint32_t& stored = blockOf[primID];
    if (stored == none) stored = block;
    else if (stored != block) otherBlocks.emplace_back(primID, block);
  };
  auto addMesh = [&](const MeshHeader* block, size_t i) {
    const MeshView view(block);
    for (uint32_t g = 0; g < view.groups; g++)
      for (uint32_t t = 0; t < groupTriangles(meshGroupByte(block, g)); t++)
        add(primitiveOfMesh(block->info, view.number(g, t)), i);
  };
  auto addMeshTile = [&](const MeshTileHeader* tile, size_t i) {
    const MeshTileView view(meshTileOfStep(tile, 0));
    for (uint32_t g = 0; g < view.groups; g++)
      for (uint32_t t = 0; t < view.triangles(g); t++) add(primitiveOfMesh(tile->meshInfo, view.number(g, t)), i);
  };
  for (size_t i = 0; i < blocks.size(); i++) {
    switch (blocks[i].contents()) {
    case FRAMED_BLOCK: break;
    case VERT_BLOCK:
    case TILE_BLOCK:
      if (!blocks[i].areQuadsPrimitives()) break;
      forEachQuad(blocks[i].vert(), [&](uint32_t x, uint32_t y) {
        for (bool isSecond : {false, true}) add(primitiveOfQuad(blocks[i].vert(), x, y, isSecond).primID, i);
      });
      break;
    case MESH_BLOCK:
      if (blocks[i].isMeshTile()) addMeshTile(blocks[i].meshTile(), i);
      else addMesh(blocks[i].mesh(), i);
      break;
    }
  }
  blockOf.shrink_to_fit();
  std::sort(otherBlocks.begin(), otherBlocks.end());
}

template<typename Closure>
void BlockIndex::forBlocksOf(uint32_t primID, const Closure& closure) const {
  if (!blockOf.empty() || !otherBlocks.empty()) {
    if (primID < blockOf.size() && blockOf[primID] != none) closure(blocks[blockOf[primID]]);
    auto other = std::lower_bound(otherBlocks.begin(), otherBlocks.end(), std::make_pair(primID, 0u));
    for (; other != otherBlocks.end() && other->first == primID; ++other) closure(blocks[other->second]);
    return;
  }
  for (auto i = std::lower_bound(blocks.begin(), blocks.end(), primID,
                                 [](const StoredBlock& block, uint32_t id) { return block.primID() < id; });
       i != blocks.end() && i->primID() == primID; i++)
    closure(*i);
}

bool BlockIndex::find(const TraversalTime& time, uint32_t primID, float u, float v, const float* Ng,
                      StoredTriangle& triangle) const {
  if (!(std::isfinite(u) && std::isfinite(v))) return false;
  Search search(time, u, v, Ng, triangle);
  forBlocksOf(primID, [&](const StoredBlock& block) { search.searchBlock(block, primID); });
  return search.found();
}

bool BlockIndex::findClosest(const TraversalTime& time, uint32_t primID, const float p[3], float radius,
                             PointOnSurface& closest) const {
  ClosestSearch search(time, p, radius, closest);
  forBlocksOf(primID, [&](const StoredBlock& block) { search.searchBlock(block, primID); });
  return search.found;
}

/*! forEachPart() for a mesh block. Returns false if closure returned false. */
static bool forEachMeshPart(const StoredBlock& block, const TraversalTime& time,
                            const std::function<bool(const StoredBlock&, const StoredPart&)>& closure) {
  struct Triangle {
    uint32_t number;
    float corners[3][3];
    bool operator<(const Triangle& other) const { return number < other.number; }
  };
  std::vector<Triangle> triangles;
  forEachMeshTriangle(block, time, [&](uint32_t number, const float(&corners)[3][3]) {
    triangles.emplace_back();
    triangles.back().number = number;
    memcpy(triangles.back().corners, corners, sizeof(corners));
  });
  std::sort(triangles.begin(), triangles.end());
  const uint32_t info = block.meshInfo();
  for (size_t i = 0; i < triangles.size(); i++) {
    const float(&p)[3][3] = triangles[i].corners;
    const uint32_t primID = primitiveOfMesh(info, triangles[i].number), primIDs[2] = {primID, primID};
    float vertices[4][3]; // 00, 10, 01, 11 of a quad
    auto set = [&](const float* v0, const float* v1, const float* v3, const float* v2) {
      const float* const from[4] = {v0, v1, v3, v2};
      for (int c = 0; c < 4; c++) memcpy(vertices[c], from[c], sizeof(vertices[c]));
    };
    const bool isSecond = isSecondOfQuad(info, triangles[i].number);
    if (isSecond) set(p[2], p[2], p[1], p[0]);
    else if (i + 1 < triangles.size() && isSecondOfQuad(info, triangles[i + 1].number) &&
             triangles[i + 1].number == triangles[i].number + 1) {
      set(p[0], p[1], p[2], triangles[i + 1].corners[0]);
      i++;
    } else set(p[0], p[1], p[2], p[1]);
    StoredPart part = StoredPart();
    part.primID = primID;
    part.width = part.height = 2;
    part.vertices = vertices[0];
    part.primIDs = primIDs;
    part.primitivesPerQuad = (info & meshHasQuads) ? 1 : 2;
    if (!closure(block, part)) return false;
  }
  return true;
}

/*! forEachPart() for a block whose quads belong to one primitive. Header: VertHeader, or Block of cGRID. */
template<typename Header>
static bool forParametrizedPart(const StoredBlock& block, const Header* header, const TraversalTime& time,
                                const std::function<bool(const StoredBlock&, const StoredPart&)>& closure) {
  const ParametrizedBlock decoded(header, time);
  StoredPart part = StoredPart();
  part.primID = header->primID;
  part.width = decoded.position.quads[0] + 1;
  part.height = decoded.position.quads[1] + 1;
  part.vertices = decoded.vertices[0].data();
  part.parameters = decoded.parameters[0].data();
  return closure(block, part);
}

/*! forEachPart() for a block whose quads or triangles are primitives. */
static bool forNumberedPart(const StoredBlock& block, const TraversalTime& time,
                            const std::function<bool(const StoredBlock&, const StoredPart&)>& closure) {
  const VertHeader* const header = block.vert();
  const uint32_t numbering = header->patchQuads;
  const VerticesAtTime decoded(header, time);
  uint32_t primIDs[2 * vertBlockQuads * vertBlockQuads], n = 0;
  forEachQuad(header, [&](uint32_t x, uint32_t y) {
    primIDs[n++] = primitiveOfQuad(header, x, y, false).primID;
    if (isTriangleNumbering(numbering)) primIDs[n++] = primitiveOfQuad(header, x, y, true).primID;
  });
  StoredPart part = StoredPart();
  part.primID = header->primID;
  part.width = vertQuadsX(header->region) + 1;
  part.height = vertQuadsY(header->region) + 1;
  part.vertices = decoded.vertices[0];
  part.primIDs = primIDs;
  part.primitivesPerQuad = isTriangleNumbering(numbering) ? 2 : 1;
  return closure(block, part);
}

void forEachPart(const SurfaceBlocks& blocks, const TraversalTime& time,
                 const std::function<bool(const StoredBlock&, const StoredPart&)>& closure) {
  forEachBlock(blocks, [&](const StoredBlock& block) {
    if (!isPresent(block, time)) return true;
    switch (block.contents()) {
    case FRAMED_BLOCK: return forParametrizedPart(block, block.framed(), time, closure);
    case VERT_BLOCK:
    case TILE_BLOCK:
      return block.areQuadsPrimitives() ? forNumberedPart(block, time, closure)
                                        : forParametrizedPart(block, block.vert(), time, closure);
    case MESH_BLOCK: return forEachMeshPart(block, time, closure);
    }
    return true;
  });
}
} // namespace embree::cbvh
