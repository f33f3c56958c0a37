// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "factory.h"
#include "../base/environment.h"
#include "../base/kinds.h"
#include "../embree/scene.h"
#include "../scene/compressed_tree.h"

namespace embree
{
  DECLARE_SYMBOL2(Accel::Intersector1,BVH4CompressedSubdivIntersector1);
  DECLARE_SYMBOL2(Accel::Intersector4,BVH4CompressedSubdivIntersector4);
  DECLARE_SYMBOL2(Accel::Intersector8,BVH4CompressedSubdivIntersector8);
  DECLARE_SYMBOL2(Accel::Intersector16,BVH4CompressedSubdivIntersector16);
  DECLARE_SYMBOL2(Accel::IntersectorN,BVH4CompressedSubdivIntersectorN);
  DECLARE_ISA_FUNCTION(Builder*,BVH4CompressedSubdivBuilder,void* COMMA Scene* COMMA CompressionReport*);

  namespace
  {
    struct Symbols
    {
      DEFINE_SYMBOL2(Accel::Intersector1,BVH4CompressedSubdivIntersector1);
      DEFINE_SYMBOL2(Accel::Intersector4,BVH4CompressedSubdivIntersector4);
      DEFINE_SYMBOL2(Accel::Intersector8,BVH4CompressedSubdivIntersector8);
      DEFINE_SYMBOL2(Accel::Intersector16,BVH4CompressedSubdivIntersector16);
      DEFINE_SYMBOL2(Accel::IntersectorN,BVH4CompressedSubdivIntersectorN);
      DEFINE_ISA_FUNCTION(Builder*,BVH4CompressedSubdivBuilder,void* COMMA Scene* COMMA CompressionReport*);

      Symbols (int features, int builderFeatures)
      {
        /* as upstream chooses GRID's builder: the vertices of both are the same floats */
        SELECT_SYMBOL_DEFAULT_AVX(builderFeatures,BVH4CompressedSubdivBuilder);
        SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features,BVH4CompressedSubdivIntersector1);
#if defined(EMBREE_RAY_PACKETS)
        SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features,BVH4CompressedSubdivIntersector4);
        SELECT_SYMBOL_INIT_AVX_AVX2_AVX512(features,BVH4CompressedSubdivIntersector8);
        SELECT_SYMBOL_INIT_AVX512(features,BVH4CompressedSubdivIntersector16);
        SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features,BVH4CompressedSubdivIntersectorN);
#endif
      }
    };
  }

  static const char* compressionName (RTCCompression compression)
  {
    cbvh::Kind kind;
    return cbvh::findKind(compression,kind) ? cbvh::describe(kind).name : "GRID";
  }

  /*! Calls closure(geomID, settings, motion) for each geometry that asks for compression, but for grids that do not get it: their commits say so. */
  template<typename Closure>
  static void forEachCompressed (const Scene* scene, const Closure& closure)
  {
    for (size_t i=0; i<scene->geometries.size(); i++)
    {
      Geometry* geometry = scene->geometries[i].ptr;
      CompressibleGeometry* const surface = geometry && geometry->isEnabled() ? compressible(geometry) : nullptr;
      if (!surface) continue;
      const CompressionSettings settings = surface->compression.resolve(scene->device->compression);
      const bool motion = geometry->numTimeSteps != 1;
      if (settings.compression != RTC_COMPRESSION_NONE && (geometryOfTree(geometry) || (motion && geometry->getType() == Geometry::GTY_SUBDIV_MESH))) closure(i,settings,motion);
    }
  }

  static bool hasCompressedGeometry (const Scene* scene)
  {
    bool compressed = false;
    forEachCompressed(scene,[&](size_t, const CompressionSettings&, bool motion) { compressed |= !motion; });
    return compressed;
  }

  bool isCompressionOutdated (Scene* scene)
  {
    if (scene->getNumPrimitives(SubdivMesh::geom_type,false) == 0) return false;
    for (Accel* accel : scene->accels)
      if (dynamic_cast<CompressedSubdivAccel*>(accel)) return !hasCompressedGeometry(scene);
    return hasCompressedGeometry(scene);
  }

  /*! says at verbosity 1 what becomes of the surfaces with motion blur, or of those without */
  static void reportCompression (Scene* scene, bool ofMotion)
  {
    if (!scene->device->verbosity(1) && !(ofMotion && environmentAsksForCommitLines())) return;
    forEachCompressed(scene,[&](size_t geomID, const CompressionSettings& settings, bool motion) {
        if (motion != ofMotion) return;
        Lock<MutexSys> lock(g_printMutex);
        std::cout << "compression: geometry " << geomID << ": " << compressionName(settings.compression);
        if (motion) std::cout << " asked for, but it has motion blur: traced by GRID";
        else if (settings.compression == RTC_COMPRESSION_VERT) {} // has no frames
        else if (settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO) std::cout << ", frame level auto";
        else std::cout << ", frame level " << settings.frameLevel;
        std::cout << std::endl;
      });
  }

  void reportCompressionOfMotionBlur (Scene* scene) { reportCompression(scene,true); }

  void reportBuildErrors (Scene* scene)
  {
    std::vector<std::string> errors;
    for (Accel* accel : scene->accels)
      if (CompressedSubdivAccel* compressed = dynamic_cast<CompressedSubdivAccel*>(accel)) {
        Lock<MutexSys> lock(compressed->report->mutex);
        errors.swap(compressed->report->errors);
      }
    for (const std::string& error : errors)
      Device::process_error(scene->device,RTC_ERROR_INVALID_ARGUMENT,error.c_str());
  }

  Accel* createCompressedSubdivAccel (Scene* scene)
  {
    scene->surfaceIDs.clear();
    if (!hasCompressedGeometry(scene)) return nullptr;
    reportCompression(scene,false);
    Device* device = scene->device;
    const Symbols symbols(device->enabled_cpu_features,device->enabled_builder_cpu_features);

    BVH4* bvh = new CompressedTree(SubdivPatch1::type,scene);
    CompressionReport* report = new CompressionReport;
    Builder* builder = symbols.BVH4CompressedSubdivBuilder(bvh,scene,report);

    Accel::Intersectors intersectors;
    intersectors.ptr = bvh;
    intersectors.intersector1  = symbols.BVH4CompressedSubdivIntersector1();
#if defined(EMBREE_RAY_PACKETS)
    intersectors.intersector4  = symbols.BVH4CompressedSubdivIntersector4();
    intersectors.intersector8  = symbols.BVH4CompressedSubdivIntersector8();
    intersectors.intersector16 = symbols.BVH4CompressedSubdivIntersector16();
    intersectors.intersectorN  = symbols.BVH4CompressedSubdivIntersectorN();
#endif
    return new CompressedSubdivAccel(bvh,builder,intersectors,report);
  }
}
