// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "../embree/scene.h"
#include "../framed/block.h"
#include "../vert/motion_format.h"
#include "../base/primitive_type.h"
#include "flat_scene.h"
#include "surface_blocks.h"
#include <limits>
#include <memory>
#include <vector>

namespace embree
{
  namespace cbvh
  {
    namespace
    {
      /*! what a FlatScene points to */
      struct OwnedScene : public FlatScene
      {
        std::vector<FlatNode> ownNodes;
        std::vector<FlatBlock> ownBlocks;
        std::vector<FlatCell> ownCells;
        std::vector<FlatGeometry> ownGeometries;
      };

      uint32_t bytesOfBlock (uint32_t kind, const void* data)
      {
        if (kind == kindVert) return vertBytes((const VertHeader*)data);
        return blockLayout(kind,heightOf(((const BlockHeader*)data)->info)).bytes;
      }

      /*! Copies the tree of subdivision surfaces, that of each grid included. */
      class TreeCopy
      {
      public:
        TreeCopy (OwnedScene& out, const SurfaceIDs& ids) : out(out), ids(ids) {}

        void copy (BVH4::NodeRef root)
        {
          out.depth = 0;
          out.root = reference(root,nullptr,0);
        }

      private:
        typedef isa::GridSOA GridSOA;
        static_assert(offsetof(GridSOA,width) == 4*gridWidthWord && offsetof(GridSOA,height) == 4*gridHeightWord && offsetof(GridSOA,dim_offset) == 4*gridPlaneWord &&
                      offsetof(GridSOA,_geomID) == 4*gridGeometryWord && offsetof(GridSOA,_primID) == 4*gridPrimitiveWord &&
                      offsetof(GridSOA,gridOffset) == 4*gridOffsetWord && offsetof(GridSOA,data) == 4*gridDataWord,"layout of a grid");

        /*! grid: that a node belongs to, index gridIndex of blocks, or null above the grids */
        uint32_t reference (BVH4::NodeRef ref, const GridSOA* grid, uint32_t gridIndex, uint32_t above = 0)
        {
          if (ref == BVH4::emptyNode) return emptyReference;
          if (ref.isLeaf()) return leaf(ref,grid,gridIndex,above);
          if (!ref.isAABBNode()) throw_RTCError(RTC_ERROR_INVALID_OPERATION,"a subdivision surface has motion blur");
          return node(ref.getAABBNode(),grid,gridIndex,above);
        }

        uint32_t node (const BVH4::AABBNode* from, const GridSOA* grid, uint32_t gridIndex, uint32_t above)
        {
          const size_t n = out.ownNodes.size();
          out.ownNodes.emplace_back();
          out.depth = max(out.depth,above+1);
          uint32_t children[4];
          for (size_t i=0; i<4; i++) children[i] = reference(from->child(i),grid,gridIndex,above+1);
          FlatNode& to = out.ownNodes[n];
          const vfloat4* lower[3] = { &from->lower_x,&from->lower_y,&from->lower_z };
          const vfloat4* upper[3] = { &from->upper_x,&from->upper_y,&from->upper_z };
          for (size_t i=0; i<4; i++) {
            to.children[i] = children[i];
            const bool isEmpty = children[i] == emptyReference;
            for (size_t k=0; k<3; k++) {
              to.lower[k][i] = isEmpty ? std::numeric_limits<float>::infinity() : (*lower[k])[i];
              to.upper[k][i] = isEmpty ? std::numeric_limits<float>::infinity() : (*upper[k])[i];
            }
          }
          return makeReference(nodeReference,index(n));
        }

        uint32_t leaf (BVH4::NodeRef ref, const GridSOA* grid, uint32_t gridIndex, uint32_t above)
        {
          size_t type;
          const char* data = ref.leaf(type);
          if (grid) {
            out.ownCells.push_back(FlatCell{ gridIndex,uint32_t((size_t(data) >> 4) - 1) });
            return makeReference(cellReference,index(out.ownCells.size()-1));
          }
          if (type == GRID_SOA_ROOT) {
            const GridSOA* root = (const GridSOA*)data;
            if (root->time_steps != 1) throw_RTCError(RTC_ERROR_INVALID_OPERATION,"a subdivision surface has motion blur");
            out.ownBlocks.push_back(FlatBlock{ root,uint32_t(offsetof(GridSOA,data)) + root->rootOffset,cellReference,ids[root->geomID()] });
            return reference(root->root(),root,index(out.ownBlocks.size()-1),above);
          }
          const bool isVert = type == VERT_BLOCK;
          const uint32_t kind = isVert ? kindVert : kindOf(((const BlockHeader*)data)->info);
          const uint32_t surface = isVert ? ((const VertHeader*)data)->surface : ((const BlockHeader*)data)->surface;
          out.ownBlocks.push_back(FlatBlock{ data,bytesOfBlock(kind,data),blockReference(kind),ids[surface] });
          return makeReference(blockReference(kind),index(out.ownBlocks.size()-1));
        }

        static uint32_t index (size_t i)
        {
          if (i > referenceMask) throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the scene has more than " + std::to_string(size_t(referenceMask)+1) + " nodes, blocks or leaves of grids");
          return uint32_t(i);
        }

        OwnedScene& out;
        const SurfaceIDs& ids;
      };

      void copyVector (const Vec3fa& from, float* to) { to[0] = from.x; to[1] = from.y; to[2] = from.z; }

      void copyTransform (const AffineSpace3fa& from, float* to)
      {
        copyVector(from.l.vx,to); copyVector(from.l.vy,to+3); copyVector(from.l.vz,to+6); copyVector(from.p,to+9);
      }

      const char* nameOfType (Geometry::GType type)
      {
        switch (int(type)) {
        case Geometry::GTY_SUBDIV_MESH: return "a subdivision surface";
        case CompressibleGeometry::GTY_COMPRESSED: return "a compressed mesh";
        case Geometry::GTY_TRIANGLE_MESH: return "a triangle mesh";
        case Geometry::GTY_INSTANCE_CHEAP: case Geometry::GTY_INSTANCE_EXPENSIVE: return "an instance";
        case Geometry::GTY_QUAD_MESH: return "a quad mesh";
        case Geometry::GTY_GRID_MESH: return "a grid mesh";
        case Geometry::GTY_USER_GEOMETRY: return "user geometry";
        default: return "of curves or points";
        }
      }

      FlatGeometry describe (Geometry* geometry)
      {
        FlatGeometry out = FlatGeometry();
        if (!geometry || !geometry->isEnabled()) return out;
        out.typeName = nameOfType(geometry->getType());
        out.mask = geometry->mask;
        out.timeSteps = geometry->numTimeSteps;
        out.hasFilter = geometry->hasFilterFunctions();
        switch (int(geometry->getType()))
        {
        case Geometry::GTY_SUBDIV_MESH: case CompressibleGeometry::GTY_COMPRESSED: {
          const auto blocks = blocksOf((const CompressibleGeometry*)geometry);
          out.type = FLAT_SURFACE;
          out.build = blocks ? blocks->build : 0;
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
        case Geometry::GTY_INSTANCE_CHEAP: case Geometry::GTY_INSTANCE_EXPENSIVE: {
          Instance* instance = (Instance*)geometry;
          out.type = FLAT_INSTANCE;
          if (instance->numTimeSteps == 1) {
            copyTransform(instance->getWorld2Local(),out.worldToLocal);
            copyTransform(instance->getLocal2World(),out.localToWorld);
          }
          out.instanced = (RTCScene)dynamic_cast<Scene*>(instance->object);
          if (instance->object) {
            const BBox3fa bounds = instance->object->getBounds();
            copyVector(bounds.lower,out.lower);
            copyVector(bounds.upper,out.upper);
          }
          break;
        }
        default: out.type = FLAT_OTHER;
        }
        return out;
      }

      std::unique_ptr<OwnedScene> flatten (Scene* scene)
      {
        std::unique_ptr<OwnedScene> flat(new OwnedScene);
        static_cast<FlatScene&>(*flat) = FlatScene();
        flat->version = flatSceneVersion;
        flat->root = emptyReference;
        flat->isRobust = scene->isRobustAccel();
        bool hasMotion = false;
        for (size_t i=0; i<scene->size(); i++) flat->ownGeometries.push_back(describe(scene->get(i)));

        /* what uses this names the geometry */
        for (const FlatGeometry& geometry : flat->ownGeometries)
          hasMotion |= geometry.type == FLAT_SURFACE && geometry.timeSteps != 1;

        for (Accel* accel : scene->accels)
        {
          if (hasMotion) break;
          const AccelData* data = (const AccelData*)accel->intersectors.ptr;
          if (!data || data->type != AccelData::TY_BVH4 || ((const BVH4*)data)->primTy != &SubdivPatch1::type) continue;
          const BVH4* bvh = (const BVH4*)data;
          TreeCopy(*flat,scene->surfaceIDs).copy(bvh->root);
          copyVector(bvh->getBounds().lower,flat->lower);
          copyVector(bvh->getBounds().upper,flat->upper);
        }

        flat->nodes = flat->ownNodes.data();
        flat->numNodes = flat->ownNodes.size();
        flat->blocks = flat->ownBlocks.data();
        flat->numBlocks = flat->ownBlocks.size();
        flat->cells = flat->ownCells.data();
        flat->numCells = flat->ownCells.size();
        flat->geometries = flat->ownGeometries.data();
        flat->numGeometries = flat->ownGeometries.size();
        return flat;
      }
    }
  }
}

using namespace embree;

RTC_NAMESPACE_BEGIN;

RTC_API const cbvh::FlatScene* rtcFlattenScene (RTCScene hscene, unsigned int version)
{
  Scene* scene = (Scene*) hscene;
  RTC_CATCH_BEGIN;
  if (hscene == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"scene is NULL");
  if (version != cbvh::flatSceneVersion)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,"libembree3 and libembree3_vulkan are of different builds: one has scenes of version "
                   + std::to_string(cbvh::flatSceneVersion) + ", the other of " + std::to_string(version));
  bool modified = scene->isModified();
  for (size_t i=0; i<scene->size(); i++)
    modified |= scene->get(i) && scene->get(i)->isEnabled() && scene->isGeometryModified(i);
  if (modified)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,"scene not committed");
  return cbvh::flatten(scene).release();
  RTC_CATCH_END2(scene);
  return nullptr;
}

RTC_API void rtcRaiseDeviceError (RTCDevice device, enum RTCError code, const char* message) { Device::process_error((Device*)device,code,message); }

RTC_API void rtcReleaseFlatScene (const cbvh::FlatScene* flat) { delete static_cast<const cbvh::OwnedScene*>(flat); }

RTC_NAMESPACE_END
