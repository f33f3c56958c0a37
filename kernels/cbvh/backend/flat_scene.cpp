// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "../embree/scene.h"
#include "../base/block_validity.h"
#include "../blocks/block_table.h"
#include "../blocks/report.h"
#include "flat_scene.h"
#include "../blocks/surface_blocks.h"
#include "../../cvert/conversion/mesh_tile_conversion.h"
#include "../../cvert/conversion/tile_conversion.h"
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

namespace embree::cbvh { namespace {
struct alignas(blockAlignment) BlockPiece {
  uint8_t bytes[blockAlignment];
};

/*! The memory that the pointers of a FlatScene refer to. */
struct OwnedScene : public FlatScene {
  std::vector<FlatNode> ownNodes;
  std::vector<FlatMovingNode> ownMovingNodes;
  std::vector<FlatBlock> ownBlocks;
  std::vector<FlatGridLeaf> ownGridLeaves;
  std::vector<FlatGeometry> ownGeometries;
  std::vector<std::unique_ptr<float[]>> ownTransforms;
  std::vector<std::unique_ptr<BlockPiece[]>> blocksOfTiles;
};

void copyVector(const Vec3fa& from, float* to) {
  to[0] = from.x;
  to[1] = from.y;
  to[2] = from.z;
}

/*! Copies a tree of Embree's nodes, depth first. */
class TreeCopy {
public:
  TreeCopy(OwnedScene& out, const SurfaceIDs& ids) : out(out), ids(ids) {}

  FlatTree copy(const BVH4* bvh) {
    depth = 0;
    FlatTree tree;
    tree.root = copySubtree(bvh->root, nullptr, 0);
    tree.depth = depth;
    const BBox3fa bounds = merge(bvh->bounds.bounds0, bvh->bounds.bounds1);
    copyVector(bounds.lower, tree.lower);
    copyVector(bounds.upper, tree.upper);
    return tree;
  }

private:
  typedef isa::GridSOA GridSOA;
  static_assert(offsetof(GridSOA, width) == 4 * gridWidthWord && offsetof(GridSOA, height) == 4 * gridHeightWord &&
                    offsetof(GridSOA, dim_offset) == 4 * gridPlaneStrideWord &&
                    offsetof(GridSOA, _geomID) == 4 * gridGeomIDWord &&
                    offsetof(GridSOA, _primID) == 4 * gridPrimIDWord &&
                    offsetof(GridSOA, gridOffset) == 4 * gridOffsetWord && offsetof(GridSOA, data) == 4 * gridDataWord,
                "layout of a grid");

  /*! Copies a subtree and returns its reference. grid: the grid that contains the node, null above grids.
   *  gridIndex: its index in ownBlocks. nodesAbove: number of nodes above. */
  uint32_t copySubtree(BVH4::NodeRef ref, const GridSOA* grid, uint32_t gridIndex, uint32_t nodesAbove = 0) {
    if (ref == BVH4::emptyNode) return emptyReference;
    if (ref.isLeaf()) return copyLeaf(ref, grid, gridIndex, nodesAbove);
    depth = max(depth, nodesAbove + 1);
    return ref.isAABBNode() ? copyNode(ref.getAABBNode(), grid, gridIndex, nodesAbove)
                            : copyMovingNode(ref, nodesAbove);
  }

  uint32_t copyNode(const BVH4::AABBNode* from, const GridSOA* grid, uint32_t gridIndex, uint32_t nodesAbove) {
    const size_t n = out.ownNodes.size();
    out.ownNodes.emplace_back();
    uint32_t children[4];
    for (size_t i = 0; i < 4; i++) children[i] = copySubtree(from->child(i), grid, gridIndex, nodesAbove + 1);
    copyPlanes(&from->lower_x, children, out.ownNodes[n]);
    return makeReference(nodeReferenceType, checkedIndex(n));
  }

  uint32_t copyMovingNode(BVH4::NodeRef ref, uint32_t nodesAbove) {
    const BVH4::AABBNodeMB* const from = ref.getAABBNodeMB();
    const size_t n = out.ownMovingNodes.size();
    out.ownMovingNodes.emplace_back();
    uint32_t children[4];
    for (size_t i = 0; i < 4; i++) children[i] = copySubtree(from->child(i), nullptr, 0, nodesAbove + 1);
    FlatMovingNode& to = out.ownMovingNodes[n];
    copyPlanes(&from->lower_x, children, to.atZero);
    const vfloat4* const differences = &from->lower_dx;
    for (size_t i = 0; i < 4; i++) {
      const bool isEmpty = children[i] == emptyReference, splitsTime = ref.isAABBNodeMB4D();
      for (size_t k = 0; k < 3; k++) {
        to.lowerDifference[k][i] = isEmpty ? 0.0f : differences[2 * k][i];
        to.upperDifference[k][i] = isEmpty ? 0.0f : differences[2 * k + 1][i];
      }
      const float largest = std::numeric_limits<float>::max();
      to.begin[i] = splitsTime && !isEmpty ? ref.getAABBNodeMB4D()->lower_t[i] : -largest;
      to.end[i] = splitsTime && !isEmpty ? ref.getAABBNodeMB4D()->upper_t[i] : largest;
    }
    return makeReference(movingNodeReferenceType, checkedIndex(n));
  }

  /*! planes: in the order of Embree's nodes: lower and upper x, y, z. */
  static void copyPlanes(const vfloat4* planes, const uint32_t children[4], FlatNode& to) {
    for (size_t i = 0; i < 4; i++) {
      to.children[i] = children[i];
      const bool isEmpty = children[i] == emptyReference;
      for (size_t k = 0; k < 3; k++) {
        to.lower[k][i] = isEmpty ? std::numeric_limits<float>::infinity() : planes[2 * k][i];
        to.upper[k][i] = isEmpty ? std::numeric_limits<float>::infinity() : planes[2 * k + 1][i];
      }
    }
  }

  uint32_t copyLeaf(BVH4::NodeRef ref, const GridSOA* grid, uint32_t gridIndex, uint32_t nodesAbove) {
    size_t type;
    const char* data = ref.leaf(type);
    if (grid) { // Embree encodes the first vertex of 2 x 2 quads, plus 1, above the 4 bits of the leaf type
      out.ownGridLeaves.push_back(FlatGridLeaf{gridIndex, uint32_t((size_t(data) >> 4) - 1)});
      return makeReference(gridLeafReferenceType, checkedIndex(out.ownGridLeaves.size() - 1));
    }
    if (type == GRID_SOA_ROOT) {
      const GridSOA* root = (const GridSOA*)data;
      out.ownBlocks.push_back(FlatBlock{root, root, uint32_t(offsetof(GridSOA, data)) + root->rootOffset,
                                        gridLeafReferenceType, ids[root->geomID()]});
      return copySubtree(root->root(), root, checkedIndex(out.ownBlocks.size() - 1), nodesAbove);
    }
    const BlockType blockType = BlockType(type);
    if (!isBlockValid(data, blockType))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                     "the scene cannot be flattened: the file of one of its geometries has a damaged block");
    const BlockRow row = rowOf(blockType);
    const uint32_t childType = row.referenceType(data);
    if (childType == numReferenceTypes)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                     "the scene cannot be flattened: it has moving mesh blocks, of meshes with motion blur whose "
                     "faces lie in no grids; expected such meshes not to be compressed");
    uint32_t* const reference = row.moves(data) ? &movingBlocks[data] : nullptr;
    if (reference && *reference) return *reference;
    uint32_t surface;
    memcpy(&surface, data + row.surface, sizeof(surface));
    if (blockType == TILE_BLOCK && isMeshTile(data))
      addBlockOfMeshTile((const MeshTileHeader*)data, childType, ids[surface]);
    else if (blockType == TILE_BLOCK && reference)
      addBlockOfMovingTile((const VertHeader*)data, childType, ids[surface]);
    else out.ownBlocks.push_back(FlatBlock{data, data, row.bytes(data), childType, ids[surface]});
    const uint32_t added = makeReference(childType, checkedIndex(out.ownBlocks.size() - 1));
    if (reference) *reference = added;
    return added;
  }

  /*! Back ends decode mesh blocks. */
  void addBlockOfMeshTile(const MeshTileHeader* tile, uint32_t type, uint32_t geomID) {
    alignas(blockAlignment) uint8_t block[MeshEncoder::maxBytes];
    addOwned(block, meshOfTile(tile, encoder, block), tile, type, geomID);
  }

  /*! Back ends decode moving blocks. */
  void addBlockOfMovingTile(const VertHeader* tile, uint32_t type, uint32_t geomID) {
    if (!motionEncoder) motionEncoder.reset(new MotionEncoder);
    std::vector<uint32_t> block(maxBytesOfMovingForms(motionOf(tile).numSteps) / sizeof(uint32_t) + 1);
    MotionStatistics unused;
    const size_t bytes = movingBlockOfTile(tile, *motionEncoder, (uint8_t*)block.data(), unused);
    addOwned(block.data(), bytes, tile, type, geomID);
  }

  /*! Adds a copy of the block of a tile. */
  void addOwned(const void* block, size_t bytes, const void* tile, uint32_t type, uint32_t geomID) {
    const size_t pieces = (bytes + vertReadPadding + sizeof(BlockPiece) - 1) / sizeof(BlockPiece);
    out.blocksOfTiles.emplace_back(new BlockPiece[pieces]());
    memcpy(out.blocksOfTiles.back().get(), block, bytes);
    out.ownBlocks.push_back(FlatBlock{out.blocksOfTiles.back().get(), tile, uint32_t(bytes), type, geomID});
  }

  static uint32_t checkedIndex(size_t i) {
    if (i > maxReferenceIndex)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the scene cannot be flattened: expected at most " +
                                                      std::to_string(size_t(maxReferenceIndex) + 1) +
                                                      " nodes, blocks or leaves of grids");
    return uint32_t(i);
  }

  OwnedScene& out;
  const SurfaceIDs& ids;
  MeshEncoder encoder;
  std::unique_ptr<MotionEncoder> motionEncoder; //!< null before the first moving tile
  uint32_t depth = 0;
  /*! References to copied moving blocks: a tree contains a block once per time interval. */
  std::unordered_map<const void*, uint32_t> movingBlocks;
};

void copyTransform(const AffineSpace3fa& from, float* to) {
  copyVector(from.l.vx, to);
  copyVector(from.l.vy, to + 3);
  copyVector(from.l.vz, to + 6);
  copyVector(from.p, to + 9);
}

const char* nameOfType(Geometry::GType type) {
  switch (int(type)) {
  case Geometry::GTY_SUBDIV_MESH: return "a subdivision surface";
  case CompressibleGeometry::GTY_COMPRESSED: return "compressed geometry";
  case Geometry::GTY_TRIANGLE_MESH: return "a triangle mesh";
  case Geometry::GTY_INSTANCE_CHEAP:
  case Geometry::GTY_INSTANCE_EXPENSIVE: return "an instance";
  case Geometry::GTY_QUAD_MESH: return "a quad mesh";
  case Geometry::GTY_GRID_MESH: return "a grid mesh";
  case Geometry::GTY_USER_GEOMETRY: return "user geometry";
  default: return "of curves or points";
  }
}

/*! hasBlocks: false if Embree's own kernel has built grids for the scene's static cages. */
FlatGeometry describe(Geometry* geometry, bool hasBlocks, OwnedScene& scene) {
  FlatGeometry out = FlatGeometry();
  if (!geometry || !geometry->isEnabled()) return out;
  out.typeName = nameOfType(geometry->getType());
  out.mask = geometry->mask;
  out.numTimeSteps = geometry->numTimeSteps;
  out.isMotionSupported = out.numTimeSteps == 1 || asTreeGeometry(geometry, true) != nullptr;
  out.hasFilter = geometry->hasFilterFunctions();
  switch (int(geometry->getType())) {
  case Geometry::GTY_SUBDIV_MESH:
  case CompressibleGeometry::GTY_COMPRESSED: {
    const CompressibleGeometry* const surface = (const CompressibleGeometry*)geometry;
    // a static cage can have blocks for other scenes
    const auto blocks = surface->isCompressed() || hasBlocks ? blocksOf(surface) : nullptr;
    out.type = FLAT_SURFACE;
    out.buildID = blocks ? blocks->buildID : 0;
    break;
  }
  case Geometry::GTY_TRIANGLE_MESH: {
    const TriangleMesh* mesh = (const TriangleMesh*)geometry;
    out.type = FLAT_TRIANGLES;
    out.vertices = mesh->vertices0.getPtr();
    out.vertexStride = mesh->vertices0.getStride();
    out.numVertices = mesh->vertices0.size();
    out.indices = mesh->triangles.getPtr();
    out.indexStride = mesh->triangles.getStride();
    out.numTriangles = mesh->triangles.size();
    break;
  }
  case Geometry::GTY_INSTANCE_CHEAP:
  case Geometry::GTY_INSTANCE_EXPENSIVE: {
    Instance* instance = (Instance*)geometry;
    out.type = FLAT_INSTANCE;
    out.isMotionSupported = out.numTimeSteps == 1 || instance->gsubtype != Geometry::GTY_SUBTYPE_INSTANCE_QUATERNION;
    scene.ownTransforms.emplace_back(new float[12 * out.numTimeSteps]);
    if (out.numTimeSteps == 1) {
      copyTransform(instance->getWorld2Local(), out.worldToLocal);
      copyTransform(instance->getLocal2World(), scene.ownTransforms.back().get());
    } else
      for (uint32_t i = 0; i < out.numTimeSteps; i++)
        copyTransform(AffineSpace3fa(instance->local2world[i]), scene.ownTransforms.back().get() + 12 * i);
    out.localToWorld = scene.ownTransforms.back().get();
    out.begin = instance->time_range.lower;
    out.end = instance->time_range.upper;
    out.instanced = (RTCScene) dynamic_cast<Scene*>(instance->object);
    if (instance->object) {
      const BBox3fa bounds = instance->object->getBounds();
      copyVector(bounds.lower, out.lower);
      copyVector(bounds.upper, out.upper);
    }
    break;
  }
  default: out.type = FLAT_OTHER;
  }
  return out;
}

/*! root: not empty. */
bool isMovingTree(BVH4::NodeRef root) {
  if (!root.isLeaf()) return !root.isAABBNode();
  size_t type;
  const void* const block = root.leaf(type);
  return isBlock(type) && isBlockValid(block, BlockType(type)) && rowOf(BlockType(type)).moves(block);
}

std::unique_ptr<OwnedScene> flatten(Scene* scene) {
  std::unique_ptr<OwnedScene> flat(new OwnedScene);
  static_cast<FlatScene&>(*flat) = FlatScene();
  flat->version = flatSceneVersion;
  flat->staticTree.root = flat->movingTree.root = emptyReference;
  flat->isRobust = scene->isRobustAccel();
  bool isAllMotionSupported = true;
  const bool hasBlocks = findCompressedAccel(scene, false) != nullptr;
  for (size_t i = 0; i < scene->size(); i++) flat->ownGeometries.push_back(describe(scene->get(i), hasBlocks, *flat));

  // the trees stay empty unless all motion is supported
  for (const FlatGeometry& geometry : flat->ownGeometries)
    isAllMotionSupported &= geometry.type == FLAT_NONE || geometry.isMotionSupported;

  for (Accel* accel : scene->accels) {
    if (!isAllMotionSupported) break;
    const AccelData* data = (const AccelData*)accel->intersectors.ptr;
    if (!data || data->type != AccelData::TY_BVH4 || ((const BVH4*)data)->primTy != &SubdivPatch1::type) continue;
    const BVH4* const bvh = (const BVH4*)data;
    if (bvh->root == BVH4::emptyNode) continue;
    (isMovingTree(bvh->root) ? flat->movingTree : flat->staticTree) = TreeCopy(*flat, scene->surfaceIDs).copy(bvh);
  }

  flat->hasOwnBlocks = !flat->blocksOfTiles.empty();
  flat->nodes = flat->ownNodes.data();
  flat->numNodes = flat->ownNodes.size();
  flat->movingNodes = flat->ownMovingNodes.data();
  flat->numMovingNodes = flat->ownMovingNodes.size();
  flat->blocks = flat->ownBlocks.data();
  flat->numBlocks = flat->ownBlocks.size();
  flat->gridLeaves = flat->ownGridLeaves.data();
  flat->numGridLeaves = flat->ownGridLeaves.size();
  flat->geometries = flat->ownGeometries.data();
  flat->numGeometries = flat->ownGeometries.size();
  return flat;
}
}} // namespace embree::cbvh

using namespace embree;

RTC_NAMESPACE_BEGIN;

RTC_API const cbvh::FlatScene* rtcFlattenScene(RTCScene hscene, unsigned int version) {
  Scene* scene = (Scene*)hscene;
  RTC_CATCH_BEGIN;
  if (hscene == nullptr) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, "scene is NULL");
  if (version != cbvh::flatSceneVersion)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                   "libembree3 and libembree3_vulkan are from different builds: libembree3 "
                   "has flat scenes of version " +
                       std::to_string(cbvh::flatSceneVersion) + ", libembree3_vulkan expects version " +
                       std::to_string(version));
  bool modified = scene->isModified();
  for (size_t i = 0; i < scene->size(); i++)
    modified |= scene->get(i) && scene->get(i)->isEnabled() && scene->isGeometryModified(i);
  if (modified) throw_RTCError(RTC_ERROR_INVALID_OPERATION, "scene not committed");
  return cbvh::flatten(scene).release();
  RTC_CATCH_END2(scene);
  return nullptr;
}

RTC_API void rtcRaiseDeviceError(RTCDevice device, enum RTCError code, const char* message) {
  Device::process_error((Device*)device, code, message);
}

RTC_API void rtcReleaseFlatScene(const cbvh::FlatScene* flat) { delete static_cast<const cbvh::OwnedScene*>(flat); }

RTC_NAMESPACE_END
