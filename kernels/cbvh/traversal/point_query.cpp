// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Point queries (rtcPointQuery) over compressed geometries, and queries for the closest point
 * (base/closest_point_query.h). The application's function is called for primitives with a stored triangle within
 * reach: within the query's radius or, for Embree's AABB queries, that of the sphere around the box; plus the largest
 * distance by which a vertex of the scene was moved. A face of a subdivision surface or a grid is called at most once
 * per block. Embree has no point queries for subdivision surfaces: faces are found only if they are compressed. */

#include "queries1.h"
#include "../base/block_validity.h"
#include "../base/leaf_type.h"
#include "../../cvert/portable/world.h"
#include "../embree/scene.h"
#include "../exact/closest_visitor.h"
#include "../blocks/compressed_tree.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! Visitor of PointSearch that calls the application's function for the primitives of a block. */
class PrimitiveVisitor {
public:
  static const bool visitsQuads = true;

  /*! context: geomID is that of the geometry. deviation: added to the radius. */
  PrimitiveVisitor(PointQuery* query, PointQueryContext* context, Geometry* geometry, float deviation)
    : query(query),
      context(context),
      geometry(geometry),
      deviation(deviation) {}

  bool isChanged = false; //!< a call changed the query

  double squaredRadius() const { return double(radius()) * radius(); }
  float radius() const {
    const bool isSphere = context->query_type == POINT_QUERY_TYPE_SPHERE;
    return (isSphere ? query->radius : length(context->query_radius)) * (1.0f + 4.0f * floatUlp) + deviation;
  }
  bool isDone() const { return isCalledForAll; }

  template<typename TriangleAt, typename PointAt>
  bool visit(BlockPrimitives primitives, const VertHeader*, TrianglePlace place, const TriangleAt& triangleAt,
             const PointAt& pointAt) {
    if (!isFinite(triangleAt(place))) return false;
    if (primitives == BlockPrimitives::QUADS && !isFinite(triangleAt(TrianglePlace{place.group, place.index ^ 1u})))
      return false;
    const float before = radius();
    isCalledForAll = primitives == BlockPrimitives::ONE;
    context->primID = pointAt(VertTriangle::Sides{1.0f, 0.0f, 0.0f, 1.0f}).primID;
    isChanged |= geometry->pointQuery(query, context);
    return radius() < before;
  }

private:
  static bool isFinite(const VertTriangle& triangle) {
    const WideTriangle<double> wide = triangle.wide();
    for (int i = 0; i < 3; i++) {
      const float vertex[3] = {float(wide.at[0][i]), float(wide.at[1][i]), float(wide.at[2][i])};
      if (!embree::cbvh::isFinite(vertex)) return false;
    }
    return true;
  }

  PointQuery* const query;
  PointQueryContext* const context;
  Geometry* const geometry;
  const float deviation;
  bool isCalledForAll = false;
};

class PointQueryTraversal {
public:
  PointQueryTraversal(PointQuery* query, PointQueryContext* context)
    : query(query),
      context(context),
      closest(ClosestPointQuery::of(context)) {}

  /*! Visits the leaves of a tree, nearest children first. Returns true if a call changed the query. */
  bool operator()(const BVH4* bvh) {
    if (bvh->root == BVH4::emptyNode) return false;
    if (closest && closest != context) return skipLeaf(); // in an instance
    if (!closest) deviation = ((const CompressedTree*)bvh)->maxVertexDeviation;
    bool changed = false;
    Item stack[1 + 3 * BVH4::maxDepth];
    size_t n = 0;
    stack[n++] = Item{bvh->root, 0.0f};
    while (n) {
      const Item item = stack[--n];
      if (item.distance > maxDistance()) continue;
      if (item.ref.isLeaf()) {
        changed |= callForLeaf(item.ref);
        continue;
      }
      const size_t first = n;
      vboolf4 isPresent(true);
      const vfloat4 distance =
          item.ref.isAABBNode() ? distanceOf(item.ref.getAABBNode()) : distanceOf(item.ref, isPresent);
      for (size_t mask = movemask((distance <= vfloat4(maxDistance())) & isPresent); mask;) {
        const size_t i = bscf(mask);
        const BVH4::NodeRef child = item.ref.baseNode()->child(i);
        if (child != BVH4::emptyNode) stack[n++] = Item{child, distance[i]};
      }
      std::sort(stack + first, stack + n, [](const Item& a, const Item& b) { return a.distance > b.distance; });
    }
    return changed;
  }

private:
  struct Item {
    BVH4::NodeRef ref;
    float distance; //!< see distanceOf
  };

  bool isSphere() const { return context->query_type == POINT_QUERY_TYPE_SPHERE; }

  /*! Largest distanceOf() within reach. A call of the application's function may decrease it. Both are rounded. */
  float maxDistance() const {
    const float radius = query->radius + deviation;
    return isSphere() ? radius * radius * (1.0f + 16.0f * floatUlp) : deviation;
  }

  /*! Distances of a node's children: squared for a sphere, otherwise to the query's box. */
  vfloat4 distanceOf(const BVH4::AABBNode* node) const {
    return distanceOf(distanceTo(query->p.x, node->lower_x, node->upper_x),
                      distanceTo(query->p.y, node->lower_y, node->upper_y),
                      distanceTo(query->p.z, node->lower_z, node->upper_z));
  }

  /*! As above, for a moving node. isPresent: children that exist at the query's time. */
  vfloat4 distanceOf(BVH4::NodeRef ref, vboolf4& isPresent) const {
    const BVH4::AABBNodeMB* const node = ref.getAABBNodeMB();
    const vfloat4 time(query->time);
    if (ref.isAABBNodeMB4D())
      isPresent = (ref.getAABBNodeMB4D()->lower_t <= time) & (time < ref.getAABBNodeMB4D()->upper_t);
    auto distance = [&](float p, const vfloat4& lower, const vfloat4& lowerChange, const vfloat4& upper,
                        const vfloat4& upperChange) {
      // interpolated planes are rounded
      const vfloat4 slack =
          max(abs(lower) + abs(lowerChange), abs(upper) + abs(upperChange)) * vfloat4(4.0f * floatUlp);
      return distanceTo(p, madd(time, lowerChange, lower) - slack, madd(time, upperChange, upper) + slack);
    };
    return distanceOf(distance(query->p.x, node->lower_x, node->lower_dx, node->upper_x, node->upper_dx),
                      distance(query->p.y, node->lower_y, node->lower_dy, node->upper_y, node->upper_dy),
                      distance(query->p.z, node->lower_z, node->lower_dz, node->upper_z, node->upper_dz));
  }

  /*! x, y, z: distances of boxes from the query's point on each axis. */
  vfloat4 distanceOf(const vfloat4& x, const vfloat4& y, const vfloat4& z) const {
    if (isSphere()) return x * x + y * y + z * z;
    const Vec3fa& r = context->query_radius;
    return max(max(max(x - vfloat4(r.x), y - vfloat4(r.y)), z - vfloat4(r.z)), vfloat4(0.0f));
  }

  /*! Distances of p from intervals, 0 inside. */
  static vfloat4 distanceTo(float p, const vfloat4& lower, const vfloat4& upper) {
    return max(max(lower - vfloat4(p), vfloat4(p) - upper), vfloat4(0.0f));
  }

  /*! Calls the application's function for the primitives of a leaf. Returns true if a call changed the query. */
  bool callForLeaf(BVH4::NodeRef leaf) {
    size_t type;
    const void* block = leaf.leaf(type);
    if (!isBlock(type)) return skipLeaf();
    if (!embree::cbvh::isBlockValid(block, BlockType(type))) return false;
    if (BlockType(type) == FRAMED_BLOCK) return skipLeaf();
    if (closest) {
      ClosestVisitor visitor(query, *closest);
      search(visitor, block, BlockType(type));
      return false;
    }
    const uint32_t surface = ((const VertHeader*)block)->surface; // see cached_mesh.h
    context->geomID = context->scene->surfaceIDs[surface];
    PrimitiveVisitor visitor(query, context, context->scene->get(context->geomID), deviation);
    search(visitor, block, BlockType(type));
    return visitor.isChanged;
  }

  template<typename Visitor>
  void search(Visitor& visitor, const void* block, BlockType type) const {
    PointSearch<Visitor> search(query, visitor);
    switch (type) {
    case FRAMED_BLOCK: break;
    case VERT_BLOCK: search.searchVert((const VertHeader*)block); break;
    case TILE_BLOCK: search.searchTile((const VertHeader*)block); break;
    case MESH_BLOCK: search.searchMesh((const MeshHeader*)block); break;
    }
  }

  /*! A leaf without triangles that can be searched. */
  bool skipLeaf() {
    if (closest) closest->hasOthers = true;
    return false;
  }

  PointQuery* const query;
  PointQueryContext* const context;
  ClosestPointQuery* const closest; //!< null for queries that call the application's function
  float deviation = 0;              //!< by which the radius is enlarged
};

} // namespace embree::isa::cbvh

namespace embree::isa {
bool CompressedSubdivTraversal1::pointQuery(const Accel::Intersectors* This, PointQuery* query,
                                            PointQueryContext* context) {
  return cbvh::PointQueryTraversal(query, context)((const BVH4*)This->ptr);
}

bool CompressedMotionTraversal1::pointQuery(const Accel::Intersectors* This, PointQuery* query,
                                            PointQueryContext* context) {
  return cbvh::PointQueryTraversal(query, context)((const BVH4*)This->ptr);
}
} // namespace embree::isa
