// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Point queries (rtcPointQuery) over compressed geometries, and queries for the closest point
 * (base/closest_point_query.h), for which exact/point_search.h searches the blocks. A box is within reach if it touches
 * the query's sphere, or the query's box for Embree's AABB queries. The application's function is called, possibly
 * several times, for the primitive of each block whose box in the tree is within reach, or that is the tree's only
 * block. In blocks with numbers of quads and in mesh blocks, it is called for each quad or triangle whose box is within
 * reach. Faces of subdivision surfaces are found only if they are compressed: Embree has no point queries for them. */

#include "queries1.h"
#include "../base/block_validity.h"
#include "../base/leaf_type.h"
#include "../base/codec_names.h"
#include "../../cvert/portable/world.h"
#include "../../cvert/decoder/decoded_mesh.h"
#include "../embree/scene.h"
#include "../exact/point_search.h"
#include "../blocks/compressed_tree.h"
#include "../blocks/vertices_at_time.h"
#include <initializer_list>

namespace embree::isa::cbvh {
using namespace embree::cbvh;

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
  float maxDistance() const { return isSphere() ? query->radius * query->radius * (1.0f + 16.0f * floatUlp) : 0.0f; }

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
    if (closest) return search(block, BlockType(type));
    switch (BlockType(type)) {
    case FRAMED_BLOCK: return false;
    case VERT_BLOCK:
    case TILE_BLOCK: return callForBlock((const VertHeader*)block);
    case MESH_BLOCK: return callForBlock((const MeshHeader*)block);
    }
    return false;
  }

  /*! Searches a block for the closest point. */
  bool search(const void* block, BlockType type) {
    PointSearch search(query, *closest);
    switch (type) {
    case FRAMED_BLOCK: return skipLeaf();
    case VERT_BLOCK: search.searchVert((const VertHeader*)block); break;
    case TILE_BLOCK: search.searchTile((const VertHeader*)block); break;
    case MESH_BLOCK: search.searchMesh((const MeshHeader*)block); break;
    }
    return false;
  }

  /*! A leaf without triangles that can be searched. */
  bool skipLeaf() {
    if (closest) closest->hasOthers = true;
    return false;
  }

  bool callForBlock(const VertHeader* block) {
    Geometry* const geometry = beginBlock(block->surface);
    if (!embree::cbvh::VerticesAtTime::isPresent(block, time())) return false;
    if (hasPrimIDs(block->info)) return callQuads(geometry, block);
    context->primID = block->primID;
    return geometry->pointQuery(query, context);
  }

  bool callForBlock(const MeshHeader* block) { return callTriangles(beginBlock(block->surface), block); }

  /*! Returns the geometry of a block. */
  Geometry* beginBlock(uint32_t surface) {
    const uint32_t geomID = context->scene->surfaceIDs[surface];
    context->geomID = geomID;
    return context->scene->get(geomID);
  }

  embree::cbvh::TraversalTime time() const { return {query->time, false}; }

  /*! callForLeaf() for a block with numbers of quads. Skips primitives that are not finite. */
  bool callQuads(Geometry* geometry, const VertHeader* header) {
    const embree::cbvh::VerticesAtTime block(header, time());
    const uint32_t numbering = header->patchQuads;
    bool changed = false;
    for (uint32_t y = 0; y < vertQuadsY(header->region); y++)
      for (uint32_t x = 0; x < vertQuadsX(header->region); x++) {
        // the corners that both triangles of a quad share, and the other two
        const float *const diagonal[2] = {block.vertex(x + 1, y), block.vertex(x, y + 1)}, *const ends[2] = {
                                                                                               block.vertex(x, y),
                                                                                               block.vertex(x + 1,
                                                                                                            y + 1)};
        auto primitive = [&](bool isSecond) { return primitiveOfQuad(header, x, y, isSecond).primID; };
        if (!isTriangleNumbering(numbering))
          changed |= callForPrimitive(geometry, primitive(false), {diagonal[0], diagonal[1], ends[0], ends[1]});
        else
          for (int i = 0; i < (isSingleTriangleNumbering(numbering) ? 1 : 2); i++)
            changed |= callForPrimitive(geometry, primitive(i == 1), {diagonal[0], diagonal[1], ends[i]});
      }
    return changed;
  }

  /*! callForLeaf() for a mesh block. */
  bool callTriangles(Geometry* geometry, const MeshHeader* block) {
    if (!embree::cbvh::MeshAtTime::isPresent(block, time())) return false;
    const embree::cbvh::MeshAtTime mesh(block, time());
    bool changed = false;
    for (uint32_t g = 0; g < mesh.view.groups; g++) {
      if (!mesh.moves() && !isWithinReach(mesh.view, g)) continue;
      const DecodedMeshGroup group = mesh.group(g);
      for (uint32_t t = 0; t < group.numTriangles; t++) {
        float corners[3][3];
        for (int c = 0; c < 3; c++)
          for (int k = 0; k < 3; k++) corners[c][k] = group.corners[c][k][t];
        changed |= callForPrimitive(geometry, primitiveOfMesh(block->info, group.numbers[t]),
                                    {corners[0], corners[1], corners[2]});
      }
    }
    return changed;
  }

  /*! True if a group's box is within reach, ignoring a sheared axis. The block must not move. */
  bool isWithinReach(const MeshView& view, uint32_t g) const {
    BBox3fa bounds;
    view.groupBox(g, &bounds.lower.x, &bounds.upper.x);
    if (view.isSheared()) {
      const uint32_t m = meshShearedAxis(view.block->info);
      bounds.lower[m] = neg_inf;
      bounds.upper[m] = pos_inf;
    }
    return distanceOf(bounds) <= maxDistance();
  }

  /*! Calls the application's function for a primitive if the box of `vertices` is within reach. Returns true if
   *  the call changed the query. */
  bool callForPrimitive(Geometry* geometry, uint32_t primID, std::initializer_list<const float*> vertices) {
    BBox3fa bounds(empty);
    for (const float* p : vertices) {
      if (!embree::cbvh::isFinite(p)) return false;
      bounds.extend(Vec3fa(p[0], p[1], p[2]));
    }
    if (!(distanceOf(bounds) <= maxDistance())) return false;
    context->primID = primID;
    return geometry->pointQuery(query, context);
  }

  /*! distanceOf() for one box. */
  float distanceOf(const BBox3fa& bounds) const {
    float d[3];
    for (int k = 0; k < 3; k++) d[k] = max(max(bounds.lower[k] - query->p[k], query->p[k] - bounds.upper[k]), 0.0f);
    if (isSphere()) return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    return max(max(d[0] - context->query_radius[0], d[1] - context->query_radius[1]),
               max(d[2] - context->query_radius[2], 0.0f));
  }

  PointQuery* const query;
  PointQueryContext* const context;
  ClosestPointQuery* const closest; //!< null for queries that call the application's function
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
