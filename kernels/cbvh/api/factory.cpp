// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "factory.h"
#include "../base/kinds.h"
#include "../embree/scene.h"
#include "../blocks/compressed_tree.h"

namespace embree {
DECLARE_SYMBOL2(Accel::Intersector1, BVH4CompressedSubdivIntersector1);
DECLARE_SYMBOL2(Accel::Intersector4, BVH4CompressedSubdivIntersector4);
DECLARE_SYMBOL2(Accel::Intersector8, BVH4CompressedSubdivIntersector8);
DECLARE_SYMBOL2(Accel::Intersector16, BVH4CompressedSubdivIntersector16);
DECLARE_SYMBOL2(Accel::IntersectorN, BVH4CompressedSubdivIntersectorN);
DECLARE_ISA_FUNCTION(Builder*, BVH4CompressedSubdivBuilder, void* COMMA Scene* COMMA CompressionReport*);
DECLARE_SYMBOL2(Accel::Intersector1, BVH4CompressedMotionIntersector1);
DECLARE_SYMBOL2(Accel::Intersector4, BVH4CompressedMotionIntersector4);
DECLARE_SYMBOL2(Accel::Intersector8, BVH4CompressedMotionIntersector8);
DECLARE_SYMBOL2(Accel::Intersector16, BVH4CompressedMotionIntersector16);
DECLARE_SYMBOL2(Accel::IntersectorN, BVH4CompressedMotionIntersectorN);
DECLARE_ISA_FUNCTION(Builder*, BVH4CompressedMotionBuilder, void* COMMA Scene* COMMA CompressionReport*);

namespace {
/*! Builders and intersectors for the device's instruction set (ISA), as in Embree's BVH4Factory. */
struct Symbols {
  DEFINE_SYMBOL2(Accel::Intersector1, BVH4CompressedSubdivIntersector1);
  DEFINE_SYMBOL2(Accel::Intersector4, BVH4CompressedSubdivIntersector4);
  DEFINE_SYMBOL2(Accel::Intersector8, BVH4CompressedSubdivIntersector8);
  DEFINE_SYMBOL2(Accel::Intersector16, BVH4CompressedSubdivIntersector16);
  DEFINE_SYMBOL2(Accel::IntersectorN, BVH4CompressedSubdivIntersectorN);
  DEFINE_ISA_FUNCTION(Builder*, BVH4CompressedSubdivBuilder, void* COMMA Scene* COMMA CompressionReport*);
  DEFINE_SYMBOL2(Accel::Intersector1, BVH4CompressedMotionIntersector1);
  DEFINE_SYMBOL2(Accel::Intersector4, BVH4CompressedMotionIntersector4);
  DEFINE_SYMBOL2(Accel::Intersector8, BVH4CompressedMotionIntersector8);
  DEFINE_SYMBOL2(Accel::Intersector16, BVH4CompressedMotionIntersector16);
  DEFINE_SYMBOL2(Accel::IntersectorN, BVH4CompressedMotionIntersectorN);
  DEFINE_ISA_FUNCTION(Builder*, BVH4CompressedMotionBuilder, void* COMMA Scene* COMMA CompressionReport*);

  Symbols(int features, int builderFeatures) {
    /* same ISA as for GRID's builder, so that both compute bit-identical vertices */
    SELECT_SYMBOL_DEFAULT_AVX(builderFeatures, BVH4CompressedSubdivBuilder);
    SELECT_SYMBOL_DEFAULT_AVX(builderFeatures, BVH4CompressedMotionBuilder);
    SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features, BVH4CompressedSubdivIntersector1);
    SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features, BVH4CompressedMotionIntersector1);
#if defined(EMBREE_RAY_PACKETS)
    SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features, BVH4CompressedSubdivIntersector4);
    SELECT_SYMBOL_INIT_AVX_AVX2_AVX512(features, BVH4CompressedSubdivIntersector8);
    SELECT_SYMBOL_INIT_AVX512(features, BVH4CompressedSubdivIntersector16);
    SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features, BVH4CompressedSubdivIntersectorN);
    SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features, BVH4CompressedMotionIntersector4);
    SELECT_SYMBOL_INIT_AVX_AVX2_AVX512(features, BVH4CompressedMotionIntersector8);
    SELECT_SYMBOL_INIT_AVX512(features, BVH4CompressedMotionIntersector16);
    SELECT_SYMBOL_DEFAULT_SSE42_AVX_AVX2_AVX512(features, BVH4CompressedMotionIntersectorN);
#endif
  }

  Accel::Intersectors intersectors(BVH4* bvh, bool moves) const {
    Accel::Intersectors intersectors;
    intersectors.ptr = bvh;
    intersectors.intersector1 = moves ? BVH4CompressedMotionIntersector1() : BVH4CompressedSubdivIntersector1();
#if defined(EMBREE_RAY_PACKETS)
    intersectors.intersector4 = moves ? BVH4CompressedMotionIntersector4() : BVH4CompressedSubdivIntersector4();
    intersectors.intersector8 = moves ? BVH4CompressedMotionIntersector8() : BVH4CompressedSubdivIntersector8();
    intersectors.intersector16 = moves ? BVH4CompressedMotionIntersector16() : BVH4CompressedSubdivIntersector16();
    intersectors.intersectorN = moves ? BVH4CompressedMotionIntersectorN() : BVH4CompressedSubdivIntersectorN();
#endif
    return intersectors;
  }
};
} // namespace

static const char* compressionName(RTCCompression compression) {
  cbvh::Kind kind;
  return cbvh::findKind(compression, kind) ? cbvh::descriptionOf(kind).name : "GRID";
}

bool hasUncompressedMotion(Scene* scene) {
  /* compressed surfaces have the type GTY_COMPRESSED instead */
  for (size_t i = 0; i < scene->geometries.size(); i++) {
    const Geometry* const geometry = scene->geometries[i].ptr;
    if (geometry && geometry->isEnabled() && geometry->numTimeSteps != 1 &&
        geometry->getType() == Geometry::GTY_SUBDIV_MESH)
      return true;
  }
  return false;
}

bool isCompressionOutdated(Scene* scene) {
  for (bool moves : {false, true}) {
    if (scene->getNumPrimitives(SubdivMesh::geom_type, moves) == 0) continue;
    const CompressedAccel* const compressed = findCompressedAccel(scene, moves);
    if ((compressed != nullptr) != cbvh::hasCompressedGeometry(scene, moves)) return true;
    if (moves && compressed && !compressed->isNextToGrid && hasUncompressedMotion(scene)) return true;
  }
  return false;
}

/*! At verbosity 1, prints the settings of each compressed geometry. */
static void reportCompression(Scene* scene, bool moves) {
  if (!scene->device->verbosity(1)) return;
  for (size_t geomID = 0; geomID < scene->size(); geomID++) {
    const CompressibleGeometry* const geometry = asTreeGeometry(scene->get(geomID), moves);
    if (!geometry) continue;
    const CompressionSettings settings = geometry->compression.resolve(scene->device->compression);
    if (settings.compression == RTC_COMPRESSION_NONE) continue;
    Lock<MutexSys> lock(g_printMutex);
    std::cerr << "compression: geometry " << geomID << ": " << compressionName(settings.compression);
    const bool isCage = geometry->ownType == Geometry::GTY_SUBDIV_MESH;
    const bool isKept =
        moves ? settings.compression == RTC_COMPRESSION_CVERT : isCage || cbvh::isExact(settings.compression);
    if (!isKept)
      std::cerr << " requested, but it " << (moves ? "has motion blur" : "is a grid or mesh") << ": "
                << compressionName(RTC_COMPRESSION_CVERT);
    else if (!cbvh::isExact(settings.compression)) { // which have no frames
      if (settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO) std::cerr << ", frame level auto";
      else std::cerr << ", frame level " << settings.frameLevel;
    }
    if (moves) std::cerr << ", " << geometry->numTimeSteps << " time steps";
    std::cerr << std::endl;
  }
}

void reportBuildErrors(Scene* scene) {
  std::vector<std::string> errors;
  for (Accel* accel : scene->accels)
    if (CompressedAccel* compressed = dynamic_cast<CompressedAccel*>(accel))
      for (const std::string& error : compressed->report->takeErrors()) errors.push_back(error);
  for (const std::string& error : errors)
    Device::process_error(scene->device, RTC_ERROR_INVALID_ARGUMENT, error.c_str());
}

static Accel* createAccel(Scene* scene, bool moves) {
  if (!cbvh::hasCompressedGeometry(scene, moves)) return nullptr;
  reportCompression(scene, moves);
  const Symbols symbols(scene->device->enabled_cpu_features, scene->device->enabled_builder_cpu_features);
  std::unique_ptr<BVH4> bvh(new CompressedTree(SubdivPatch1::type, scene));
  std::unique_ptr<CompressionReport> report(new CompressionReport);
  std::unique_ptr<Builder> builder(moves ? symbols.BVH4CompressedMotionBuilder(bvh.get(), scene, report.get())
                                         : symbols.BVH4CompressedSubdivBuilder(bvh.get(), scene, report.get()));
  Accel::Intersectors intersectors = symbols.intersectors(bvh.get(), moves);
  CompressedAccel* const accel = new CompressedAccel(bvh.get(), builder.get(), intersectors, report.get(), moves,
                                                     moves && hasUncompressedMotion(scene));
  bvh.release();
  report.release();
  builder.release();
  return accel;
}

Accel* createCompressedAccel(Scene* scene) {
  scene->surfaceIDs.clear();
  return createAccel(scene, false);
}
Accel* createCompressedMotionAccel(Scene* scene) { return createAccel(scene, true); }
} // namespace embree
