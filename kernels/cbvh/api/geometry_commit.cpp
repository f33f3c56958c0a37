// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Commits of geometries, as far as compression has a part in them. */

#include "../embree/scene.h"
#include "../scene/surface_blocks.h"

namespace embree
{
  DECLARE_ISA_FUNCTION(void,buildBlocksOfGeometry,SubdivMesh*);

  namespace
  {
    struct Symbols
    {
      DEFINE_ISA_FUNCTION(void,buildBlocksOfGeometry,SubdivMesh*);

      explicit Symbols (int features) { SELECT_SYMBOL_DEFAULT_AVX(features,buildBlocksOfGeometry); }
    };

    /*! Runs what a commit of a scene would run, as that does: with denormal numbers as zero, and apart from the application's tasks. */
    template<typename Closure>
    void runAsCommit (const Closure& closure)
    {
      struct Rounding
      {
        const unsigned int before;
        Rounding () : before(_mm_getcsr()) { _mm_setcsr(before | /* FTZ */ (1<<15) | /* DAZ */ (1<<6)); }
        ~Rounding () { _mm_setcsr(before); }
      } rounding;
#if defined(TASKING_INTERNAL)
      Ref<TaskScheduler> scheduler = new TaskScheduler;
      scheduler->spawn_root(closure,1,true);
#else
      tbb::task_group_context context(tbb::task_group_context::isolated,tbb::task_group_context::default_traits | tbb::task_group_context::fp_settings);
      tbb::parallel_for(size_t(0),size_t(1),size_t(1),[&] (size_t) { closure(); },context);
#endif
    }
  }

  bool beginGeometryCommit (SubdivMesh* mesh)
  {
    SurfaceState& surface = mesh->surface;
    if (surface.isKept(mesh->modCounter_)) return false;
    if (surface.inputReleased && !(mesh->vertices[0] && mesh->faceVertices && mesh->topology[0].vertexIndices))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry has let its input go (RTC_COMPRESSION_FLAG_RELEASE_INPUT): set vertices, faces and indices again before it is committed");
    surface.inputReleased = false;
    surface.blocks.reset();
    return true;
  }

  void endGeometryCommit (SubdivMesh* mesh)
  {
    mesh->surface.commit(mesh->modCounter_);
    Device* device = mesh->device;
    if (!mesh->compression.releasesInput || mesh->surface.blocks || mesh->numTimeSteps != 1) return;
    if (mesh->compression.resolve(device->compression).compression == RTC_COMPRESSION_NONE) return;
    const Symbols symbols(device->enabled_builder_cpu_features);
    runAsCommit([&] { symbols.buildBlocksOfGeometry(mesh); });
    releaseInput(mesh);
  }

  /*! Buffers of vertex attributes stay, and what they are interpolated by. */
  void releaseInput (SubdivMesh* mesh)
  {
    const bool hasAttributes = !mesh->vertexAttribs.empty();
    mesh->surface.inputReleased = true;
    for (auto& buffer : mesh->vertices) buffer = BufferView<Vec3fa>();
    for (auto& tags : mesh->vertex_buffer_tags) std::vector<SharedLazyTessellationCache::CacheEntry>().swap(tags);
    for (auto& topology : mesh->topology) {
      topology.vertexIndices = BufferView<unsigned int>();
      std::vector<SubdivMesh::KeyHalfEdge>().swap(topology.halfEdges0);
      std::vector<SubdivMesh::KeyHalfEdge>().swap(topology.halfEdges1);
      if (!hasAttributes) topology.halfEdges.clear();
    }
    mesh->faceVertices = BufferView<unsigned int>();
    mesh->edge_creases = BufferView<SubdivMesh::Edge>();
    mesh->edge_crease_weights = BufferView<float>();
    mesh->vertex_creases = BufferView<unsigned int>();
    mesh->vertex_crease_weights = BufferView<float>();
    mesh->levels = BufferView<float>();
    mesh->holes = BufferView<unsigned>();
    mesh->halfEdgeFace.clear();
    if (hasAttributes) return;
    mesh->faceStartEdge.clear();
    mesh->invalid_face.clear();
  }

  void requireInput (const SubdivMesh* mesh, RTCBufferType type)
  {
    if (mesh->surface.inputReleased && type == RTC_BUFFER_TYPE_VERTEX)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry has let its vertices go (RTC_COMPRESSION_FLAG_RELEASE_INPUT)");
  }
}
