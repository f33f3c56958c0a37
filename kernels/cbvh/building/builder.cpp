// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Builds the static or the moving surfaces of a scene when it is committed: first the blocks of geometries that changed
 * (surface_builder.h), then a tree over the parts of all static surfaces, or over all moving blocks (motion_tree.h).
 * Compiled for the lowest ISA and AVX, like Embree's builder of subdivision surfaces. */

#include "../base/environment.h"
#include "../base/thread_cache.h"
#include "cage_source.h"
#include "commit_line.h"
#include "form_choice.h"
#include "../blocks/wide_tree.h"
#include "grid_source.h"
#include "input_bytes.h"
#include "moving_blocks.h"
#include "../blocks/report.h"
#include "surface_builder.h"
#include <algorithm>

namespace embree::isa {
typedef std::shared_ptr<const cbvh::SurfaceNumber> SurfaceNumberPointer;

typedef std::unique_ptr<SurfaceBuilder> BuilderPointer;

template<typename Grids>
static BuilderPointer newMeshBuilder(typename Grids::Mesh* mesh, const SurfaceNumberPointer& number,
                                     const CompressionPlan& plan) {
  std::unique_ptr<IrregularBlocks> irregular;
  const std::shared_ptr<const QuadRegions> regions = regionsOf(mesh);
  if (regions->hasIrregular()) irregular.reset(new IrregularBlocks(TrianglesOfMesh(mesh), regions, plan, mesh->device));
  // mesh blocks of all primitives count those with invalid indices themselves
  const size_t numInvalid = regions->areAllIrregular ? 0 : regions->numInvalid,
               invalidQuads = TrianglesOfMesh(mesh).areHalvesOfQuads() ? numInvalid : (numInvalid + 1) / 2;
  return BuilderPointer(
      new SourceBuilder<GridSource<Grids>>(mesh, number, plan, std::move(irregular), invalidQuads,
                                           [mesh](InvalidInput& out) { return findInvalid(mesh, out); }));
}

static BuilderPointer newSurfaceBuilder(CompressibleGeometry* geometry, const SurfaceNumberPointer& number,
                                        const CompressionPlan& plan) {
  switch (geometry->ownType) {
  case Geometry::GTY_GRID_MESH:
    return BuilderPointer(new SourceBuilder<GridSource<GridsOfGridMesh>>(
        (GridMesh*)geometry, number, plan, nullptr, 0,
        [geometry](InvalidInput& out) { return findInvalid((GridMesh*)geometry, out); }));
  case Geometry::GTY_QUAD_MESH: return newMeshBuilder<GridsOfQuadMesh>((QuadMesh*)geometry, number, plan);
  case Geometry::GTY_TRIANGLE_MESH: return newMeshBuilder<GridsOfTriangleMesh>((TriangleMesh*)geometry, number, plan);
  default: return BuilderPointer(new SourceBuilder<CageSource>((SubdivMesh*)geometry, number, plan));
  }
}

class CompressedBuilder : public Builder {
  ALIGNED_CLASS_(64);

  static const size_t surfacesPerTask = 16;

  BVH4* bvh;
  Scene* scene;
  CompressionReport* report;
  const bool moves;
  std::vector<uint64_t> buildIDsInTree; //!< of each surface in the tree; empty without a tree
  cbvh::BudgetedBytes treeBytes;        //!< nodes of the scene's own tree

  struct Surface {
    CompressibleGeometry* geometry;
    unsigned geomID;
    SurfaceNumberPointer number;
    CompressionPlan plan;
    std::shared_ptr<const SurfaceBlocks> blocks; //!< null until built

    Surface(CompressibleGeometry* geometry, unsigned geomID)
      : geometry(geometry),
        geomID(geomID),
        number(cbvh::numberOf(geometry)),
        plan(geometry, *number),
        blocks(cbvh::blocksOf(geometry)) {}

    bool isCage() const { return geometry->ownType == Geometry::GTY_SUBDIV_MESH; }

    /*! True if the scene chooses between tiles and cVERT, also for surfaces of files. Moving surfaces stay cVERT: a
     *  scene's static and moving surfaces are built at the same time, and could both take the same memory. */
    bool hasChosenForm() const {
      if (plan.moves()) return false;
      const RTCCompression form = geometry->device->compression.compression;
      const bool mayBecomeTiles =
          blocks->mapped ? form == RTC_COMPRESSION_CTILE || form == RTC_COMPRESSION_INHERIT : plan.mayBecomeTiles();
      return mayBecomeTiles && cbvh::isConvertible(*blocks);
    }
  };

public:
  CompressedBuilder(BVH4* bvh, Scene* scene, CompressionReport* report, bool moves)
    : bvh(bvh),
      scene(scene),
      report(report),
      moves(moves),
      treeBytes(scene->device->compression.memory) {}

  void clear() {
    buildIDsInTree.clear();
    treeBytes.set(0);
    bvh->set(BVH4::emptyNode, empty, 0);
    tree().wide.clear();
    tree().wideMoving.clear();
  }

  void build() {
    report->clear();
    std::vector<Surface> surfaces = findSurfaces();
    const std::vector<uint64_t> before = buildIDsInTree;
    const bool reusesTree = !surfaces.empty() && buildIDsInTree == buildIDsOf(surfaces);
    if (!reusesTree) clear();
    if (surfaces.empty()) return;
    const double t0 = bvh->preBuild(moves ? TOSTRING(isa) "::BVH4CompressedMotionBuilder"
                                          : TOSTRING(isa) "::BVH4CompressedSubdivBuilder");
    buildBlocks(surfaces);
    if (reusesTree) listBlocks(surfaces);
    else buildTrees(surfaces);
    cbvh::BuildStatistics total;
    std::set<const void*> counted;
    for (const Surface& surface : surfaces) {
      add(surface, total);
      reportInvalid(surface, before);
      reportUnsupported(surface, before);
      if (surface.plan.compresses()) total.sums.inputBytes += bytesOfInput(surface.geometry, counted);
    }
    total.sums.topLevelBytes += treeBytes.get();
    report->statistics = total.sums;
    tree().maxVertexDeviation = total.sums.maxVertexDeviation;
    report->statistics.cacheBytesPerThread = cbvh::threadCacheBytes(cachesOf(surfaces));
    cbvh::updateSurfaceIDs(scene);
    reportCommit(surfaces);
    cbvh::invalidateThreadCaches();
    bvh->cleanup();
    bvh->postBuild(t0);
  }

private:
  std::vector<Surface> findSurfaces() const {
    std::vector<Surface> surfaces;
    for (size_t i = 0; i < scene->size(); i++) {
      CompressibleGeometry* const geometry = asTreeGeometry(scene->get(i), moves);
      if (geometry && geometry->size() != 0) surfaces.emplace_back(geometry, unsigned(i));
    }
    return surfaces;
  }

  /*! Returns SurfaceBlocks::buildID of each surface, or 0 if its blocks must be built. */
  static std::vector<uint64_t> buildIDsOf(const std::vector<Surface>& surfaces) {
    std::vector<uint64_t> buildIDs;
    for (const Surface& surface : surfaces) buildIDs.push_back(surface.blocks ? surface.blocks->buildID : 0);
    return buildIDs;
  }

  /*! Builds missing blocks: first small surfaces, several per task, then medium ones in parallel, then large ones
   *  one by one, because each uses all threads and much temporary memory. */
  void buildBlocks(std::vector<Surface>& surfaces) {
    std::vector<BuilderPointer> builders(surfaces.size());
    parallel_for(size_t(0), surfaces.size(), surfacesPerTask, [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++) {
        if (surfaces[i].blocks) {
          scene->progressMonitor(double(surfaces[i].geometry->size()));
          continue;
        }
        builders[i] = newSurfaceBuilder(surfaces[i].geometry, surfaces[i].number, surfaces[i].plan);
        if (builders[i]->isSmall()) build(surfaces[i], builders[i]);
      }
    });
    parallel_for(size_t(0), surfaces.size(), size_t(1), [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++)
        if (builders[i] && !builders[i]->isLarge()) build(surfaces[i], builders[i]);
    });
    for (size_t i = 0; i < surfaces.size(); i++)
      if (builders[i]) build(surfaces[i], builders[i]);
  }

  void build(Surface& surface, BuilderPointer& builder) {
    surface.blocks = cbvh::setBlocks(surface.geometry,
                                     builder->build([&](double primitives) { scene->progressMonitor(primitives); }));
    builder.reset();
  }

  /*! Returns the mask of ThreadCaches that rays through the surfaces may use. */
  static unsigned cachesOf(const std::vector<Surface>& surfaces) {
    unsigned caches = 0;
    for (const Surface& surface : surfaces)
      for (unsigned rest = surface.blocks->types; rest; rest &= rest - 1) {
        const size_t type = bsf(rest);
        if (!cbvh::isBlock(type)) continue;
        const cbvh::BlockRow row = cbvh::rowOf(cbvh::BlockType(type));
        caches |= surface.blocks->moving.empty() ? row.cache : row.movingCache;
      }
    return caches;
  }

  void add(const Surface& surface, cbvh::BuildStatistics& total) {
    total.add(surface.blocks->statistics);
    const cbvh::SurfaceStatistics& statistics = surface.blocks->statistics;
    if (statistics.sums.numInvalidQuads && surface.geomID < total.sums.firstInvalidGeometry &&
        statistics.firstInvalidFace < total.sums.noPrimitive) {
      total.sums.firstInvalidGeometry = surface.geomID;
      total.sums.firstInvalidPrimitive = unsigned(statistics.firstInvalidFace);
    }
    reportAtVerbosity1(surface);
  }

  /*! True if the previous commit of the scene did not report on these blocks. before: its buildIDsInTree. */
  bool isNew(const Surface& surface, const std::vector<uint64_t>& before) const {
    return scene->isGeometryModified(surface.geomID) &&
           std::find(before.begin(), before.end(), surface.blocks->buildID) == before.end();
  }

  /*! Reports invalid faces or grids, unless the previous commit did. Faces without surface are no error unless the
   *  application expects one, because Embree skips them silently, and programs rely on it. */
  void reportInvalid(const Surface& surface, const std::vector<uint64_t>& before) const {
    const cbvh::SurfaceStatistics& statistics = surface.blocks->statistics;
    if (!statistics.invalidFaces || !isNew(surface, before)) return;
    const std::string text = describeInvalid(surface);
    if (statistics.invalidFaces != statistics.facesWithoutSurface || !surface.geometry->compression.warnsOfFaces)
      return report->addError(text);
    Lock<MutexSys> lock(g_printMutex);
    std::cerr << "compression: " << text << std::endl;
  }

  /*! Prints which faces Embree cannot evaluate, unless the previous commit did. No error, because Embree skips them
   *  silently, and programs rely on it. */
  void reportUnsupported(const Surface& surface, const std::vector<uint64_t>& before) const {
    const cbvh::SurfaceStatistics& statistics = surface.blocks->statistics;
    if (!statistics.sums.numUnsupportedFaces || !surface.geometry->compression.warnsOfFaces) return;
    if (!isNew(surface, before) && !scene->device->verbosity(1)) return;
    Lock<MutexSys> lock(g_printMutex);
    std::cerr << "compression: geometry " << surface.geomID << ": " << statistics.sums.numUnsupportedFaces
              << " faces, beginning with face " << statistics.firstUnsupportedFace << ", are left out: expected 3 to "
              << MAX_PATCH_VALENCE << " corners in them and in the faces at their vertices, and at most "
              << MAX_RING_FACE_VALENCE << " faces per vertex (" << MAX_RING_FACE_VALENCE - 1
              << " at a border, fewer if these have more than 4 corners)" << std::endl;
  }

  /*! Builds the scene's trees, before which surfaces may get another form if the device has a budget. */
  void buildTrees(std::vector<Surface>& surfaces) {
    const cbvh::MemoryBudget* const memory = scene->device->compression.memory.get();
    if (!memory) return buildTree(surfaces);
    FormChoice forms(scene);
    for (Surface& surface : surfaces)
      if (surface.hasChosenForm()) forms.add(surface.geometry, surface.blocks);
    for (size_t expected = expectedTreeBytes(surfaces);;) {
      forms.choose(expected);
      buildTree(surfaces);
      if (memory->used() <= memory->limit) return;
      if (!forms.hasTiles()) break;
      expected = max(expected, treeBytes.get());
      clear();
      report->surfaces.clear(); // surfaces that will be converted
    }
    const size_t needed = memory->used();
    clear();
    throw_RTCError(
        RTC_ERROR_OUT_OF_MEMORY,
        "the device's compressed surfaces need at least " + std::to_string(needed) +
            " bytes, more than their limit (cbvh_memory in the device string, or memory in EMBREE_CBVH) of " +
            std::to_string(memory->limit));
  }

  /*! Estimates the bytes of nodes that a scene adds to those of its surfaces, if it has tiles. */
  static size_t expectedTreeBytes(const std::vector<Surface>& surfaces) {
    const size_t bytesPerBlock = 96; // wide nodes: measured 60 to 87 (docs/measurements.md)
    size_t bytes = 0;
    for (const Surface& surface : surfaces)
      bytes += surface.blocks->numPrimRefs * bytesPerBlock + surface.blocks->parts.size() * sizeof(BVH4::AABBNode) / 2;
    return bytes;
  }

  void listBlocks(const std::vector<Surface>& surfaces) {
    report->surfaces.clear();
    for (const Surface& surface : surfaces) report->surfaces.push_back(surface.blocks);
  }

  void buildTree(const std::vector<Surface>& surfaces) {
    listBlocks(surfaces);
    const size_t bytes = moves ? buildMotionTree() : buildTopLevel() * sizeof(BVH4::AABBNode);
    treeBytes.set(bytes + buildWideTree());
    buildIDsInTree = buildIDsOf(surfaces);
  }

  /*! Builds the tree over the parts of static surfaces. If there is only one surface and it has a tree, uses that
   *  tree instead. Returns the number of new nodes. */
  size_t buildTopLevel() {
    BBox3fa bounds(empty);
    size_t numParts = 0, numPrimRefs = 0;
    for (const auto& surface : report->surfaces) {
      bounds.extend(surface->bounds);
      numParts += surface->parts.size();
      numPrimRefs += surface->numPrimRefs;
    }
    if (numParts == 0) return 0;
    if (report->surfaces.size() == 1 && report->surfaces[0]->root != BVH4::emptyNode) {
      bvh->set(report->surfaces[0]->root, LBBox3fa(bounds), numPrimRefs);
      return 0;
    }
    mvector<PrimRef> parts(scene->device, numParts);
    size_t n = 0;
    for (const auto& surface : report->surfaces)
      for (const PrimRef& part : surface->parts) parts[n++] = part;
    bvh->alloc.init_estimate(numParts * sizeof(BVH4::AABBNode) / 2);
    size_t nodes = 0;
    const BVH4::NodeRef root = isa::buildTree(bvh->alloc, parts, [&] { scene->progressMonitor(0.0); }, nodes);
    bvh->set(isa::moveLargestNodes(root, nodes, bvh->alloc), LBBox3fa(bounds), numPrimRefs);
    return nodes;
  }

  CompressedTree& tree() const { return *(CompressedTree*)bvh; }

  /*! Builds the tree of wide nodes if there are tiles, which are stored for speed, and no blocks that need the BVH4.
   *  Returns the bytes of its nodes. */
  size_t buildWideTree() {
    const uint32_t tile = 1u << cbvh::TILE_BLOCK, wide = tile | 1u << cbvh::VERT_BLOCK | 1u << cbvh::MESH_BLOCK;
    uint32_t types = 0;
    for (const auto& surface : report->surfaces) types |= surface->types;
    if (!(types & tile) || (types & ~wide)) return 0;
    const BBox3fa bounds = bvh->bounds.bounds();
    if (moves) WideTreeBuilder<MovingWideTree>(bvh->root, bounds, tree().wideMoving);
    else WideTreeBuilder<StaticWideTree>(bvh->root, bounds, tree().wide);
    return tree().wide.size() * sizeof(WideNode) + tree().wideMoving.size() * sizeof(WideMovingNode);
  }

  /*! Builds the tree over the blocks of moving surfaces, and releases their boxes, which only the first build uses.
   *  Returns the bytes of its nodes. */
  size_t buildMotionTree() {
    MovingBlocks blocks(scene->device);
    size_t numBlocks = 0;
    for (const auto& surface : report->surfaces) numBlocks += surface->moving.size();
    blocks.reserve(numBlocks);
    for (const auto& surface : report->surfaces) blocks.add(*surface, [&] { scene->progressMonitor(0.0); });
    bvh->alloc.init_estimate(blocks.size() * sizeof(BVH4::AABBNodeMB) / 2);
    MotionTree motionTree;
    const BVH4::NodeRef root =
        motionTree.build(scene->device, bvh->alloc, blocks.all(), [&] { scene->progressMonitor(0.0); });
    bvh->set(root, motionTree.bounds, blocks.size());
    for (const auto& surface : report->surfaces)
      std::atomic_store(&surface->boxes, std::shared_ptr<const mvector<cbvh::StepBox>>());
    return motionTree.bytes;
  }

  /*! True if the builder of the scene's other surfaces, moving or static, also prints a line. */
  bool doesOtherBuilderReport() const {
    if (!cbvh::hasCompressedGeometry(scene, !moves)) return false; // there is no such builder
    for (size_t i = 0; i < scene->size(); i++) {
      const CompressibleGeometry* const geometry = asTreeGeometry(scene->get(i), !moves);
      if (geometry && geometry->size() != 0) return true;
    }
    return false;
  }

  void addToLine(const Surface& surface, CommitLine& line) const {
    const SurfaceBlocks& blocks = *surface.blocks;
    const bool hasTiles = cbvh::formOf(blocks) == cbvh::TILE_BLOCK;
    line.addCompressed(surface.geometry, surface.geomID, hasTiles ? cbvh::Kind::CTILE : surface.plan.kind(),
                       blocks.statistics);
    if (!cbvh::isConvertible(blocks)) return;
    const size_t other = cbvh::bytesInOtherForm(scene->device, blocks);
    if (other != blocks.bytes()) line.addOtherForm(hasTiles, blocks.statistics.sums.allBytes(), other);
  }

  void reportCommit(const std::vector<Surface>& surfaces) const {
    if (!scene->device->verbosity(1) && !environmentRequestsCommitLines()) return;
    CommitLine line;
    for (const Surface& surface : surfaces)
      if (surface.plan.compresses()) addToLine(surface, line);
      else line.addUncompressed(surface.geometry);
    const bool listsOthers = !doesOtherBuilderReport();
    for (size_t i = 0; i < scene->size(); i++) {
      const CompressibleGeometry* const geometry =
          scene->get(i) && scene->get(i)->isEnabled() ? asCompressible(scene->get(i)) : nullptr;
      if (!geometry || geometry->isCompressed() || !geometry->surface.rejectionReason) continue;
      if (listsOthers || (geometry->numTimeSteps != 1) == moves) line.addUncompressed(geometry);
    }
    Lock<MutexSys> lock(g_printMutex);
    std::cerr << line.text(treeBytes.get(), report->statistics) << std::endl;
  }

  /*! Prints what is left out or not stored as requested, and how much of a mesh is in grids. */
  void reportAtVerbosity1(const Surface& surface) const {
    if (!scene->device->verbosity(1)) return;
    const cbvh::SurfaceStatistics& statistics = surface.blocks->statistics;
    const std::string geometry = "compression: geometry " + std::to_string(surface.geomID) + ": ";
    Lock<MutexSys> lock(g_printMutex);
    if (statistics.highRateQuads)
      std::cerr << geometry << statistics.highRateQuads << " quads of faces with edge rates above "
                << (1u << cbvh::maxFramedLevel) << " are traced by GRID" << std::endl;
    if (statistics.framelessQuads)
      std::cerr << geometry << statistics.framelessQuads
                << " quads of blocks without a good frame (lines, outliers) are stored in full precision" << std::endl;
    if (statistics.sums.numFallbackQuads)
      std::cerr << geometry << statistics.sums.numFallbackQuads
                << " quads of faces that cLEAF represents badly (borders, creases, walls, folds) "
                   "are stored as cVERT"
                << std::endl;
    if (statistics.sums.numRawBlocks)
      std::cerr << geometry << statistics.sums.numRawBlocks
                << " cVERT blocks store floats, because packing saves nothing or a vertex is not finite" << std::endl;
    if (statistics.sums.numInvalidQuads && !surface.isCage())
      std::cerr << geometry << statistics.sums.numInvalidQuads << " quads are left out, because a vertex is not finite"
                << (surface.geometry->ownType == Geometry::GTY_GRID_MESH ? "" : " or an index is out of range")
                << firstInvalidText(statistics, primitiveName(surface.geometry)) << std::endl;
    // a file may contain any counts
    const size_t irregularQuads = min(statistics.sums.numIrregularQuads, statistics.sums.numMeshQuads);
    if (statistics.sums.numMeshQuads)
      std::cerr << geometry << statistics.sums.numMeshQuads - irregularQuads << " of " << statistics.sums.numMeshQuads
                << " quads are in grids, " << irregularQuads << " are stored in mesh blocks, or in grids of fewer than "
                << minGridSide << " quads along a side" << std::endl;
    if (statistics.quadsForHoles)
      std::cerr << geometry << statistics.quadsForHoles
                << " quads of patches with holes are stored as cLEAF, because cVOXEL cannot leave out quads"
                << std::endl;
  }

  static std::string describeInvalid(const Surface& surface) {
    const cbvh::SurfaceStatistics& statistics = surface.blocks->statistics;
    const cbvh::InvalidVertex& vertex = statistics.firstInvalidVertex;
    if (!surface.isCage())
      return "geometry " + std::to_string(surface.geomID) + ", grid " + std::to_string(statistics.firstInvalidFace) +
             ": vertices are outside of their buffer; left out: " + std::to_string(statistics.invalidFaces) +
             " grid(s)";
    return "geometry " + std::to_string(surface.geomID) + ", face " + std::to_string(statistics.firstInvalidFace) +
           (vertex.vertex == noVertex
                ? std::string(": vertices are not finite")
                : ": control vertex " + std::to_string(vertex.vertex) + " is not finite" +
                      (surface.plan.moves() ? " at time step " + std::to_string(vertex.timeStep) : std::string())) +
           "; left out of " + std::to_string(statistics.invalidFaces) +
           " face(s): " + std::to_string(statistics.sums.numInvalidQuads) + " quads";
  }
};

Builder* BVH4CompressedSubdivBuilder(void* bvh, Scene* scene, CompressionReport* report) {
  return new CompressedBuilder((BVH4*)bvh, scene, report, false);
}
Builder* BVH4CompressedMotionBuilder(void* bvh, Scene* scene, CompressionReport* report) {
  return new CompressedBuilder((BVH4*)bvh, scene, report, true);
}

/*! Builds the blocks of a geometry that releases its input (api/geometry_commit.cpp). */
void buildBlocksOfGeometry(CompressibleGeometry* geometry) {
  const CompressionSettings& settings = geometry->compression;
  std::atomic<size_t> done(0);
  const SurfaceNumberPointer number = cbvh::numberOf(geometry);
  const CompressionPlan plan(geometry, *number);
  cbvh::setBlocks(geometry, newSurfaceBuilder(geometry, number, plan)->build([&](double primitives) {
    done += size_t(primitives);
    if (settings.progress &&
        !settings.progress(settings.progressUserPtr, min(1.0, double(done) / double(geometry->size()))))
      throw_RTCError(RTC_ERROR_CANCELLED, "progress monitor forced termination");
  }));
  cbvh::invalidateThreadCaches();
}
} // namespace embree::isa
