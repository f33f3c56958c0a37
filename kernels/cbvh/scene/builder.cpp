// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Builder of compressed subdivision surfaces: every task takes faces, tessellates
 * one patch at a time, encodes its blocks into the BVH's own memory and drops the
 * vertices. The top level is Embree's binned SAH BVH4 over the blocks' bounds.
 *
 * Patches with edge rates that no block takes, and geometries that opt out, become GridSOA leaves
 * of the same BVH. */

#include "../embree/scene.h"
#include "../framed/writer.h"
#include "../surface/cage_patch.h"
#include "../vert/writer.h"
#include "../base/environment.h"
#include "commit_line.h"
#include "report.h"
#include "../base/thread_cache.h"

namespace embree
{
  namespace isa
  {
    class CompressedSubdivBuilder : public Builder
    {
      ALIGNED_CLASS_(64);

      typedef FastAllocator::CachedAllocator Allocator;

      BVH4* bvh;
      Scene* scene;
      CompressionReport* report;
      mvector<PrimRef> prims;
      cbvh::WorldBounds hitBounds; //!< of all that a ray may hit in blocks

      /*! faces of a geometry that a task takes at a time: a face is worth milliseconds at
       *  high levels, and those of one geometry may differ a lot */
      static const size_t facesPerTask = 8;

      /*! how often, in quads, a task reports progress: enough to cancel, too seldom to be felt */
      static const size_t progressQuads = 1 << 15;

    public:
      CompressedSubdivBuilder (BVH4* bvh, Scene* scene, CompressionReport* report)
        : bvh(bvh), scene(scene), report(report), prims(scene->device,0) {}

      void clear () { prims.clear(); }

      void build ()
      {
        report->statistics = RTCCompressionStatistics();
        report->errors.clear();
        prims.clear();
        if (scene->getNumPrimitives(SubdivMesh::geom_type,false) == 0) { setEmpty(); return; }
        const double t0 = bvh->preBuild(TOSTRING(isa) "::BVH4CompressedSubdivBuilder");

        std::vector<std::unique_ptr<Surface>> surfaces;
        Scene::Iterator<SubdivMesh> meshes(scene);
        size_t numFaces = 0;
        for (size_t i=0; i<meshes.size(); i++) {
          if (meshes[i] == nullptr) continue;
          surfaces.emplace_back(new Surface(scene,meshes[i],unsigned(i)));
          numFaces += meshes[i]->size();
        }
        if (numFaces == 0) { setEmpty(); bvh->postBuild(t0); return; }

        hitBounds = cbvh::WorldBounds();
        bvh->alloc.init_estimate(estimateBytes(surfaces));
        cbvh::BuildStatistics all;
        std::vector<TaskPrims> lists;
        for (auto& surface : surfaces)
          buildFaces(*surface,all,lists);
        report->statistics = all.sums;

        buildTopLevel(collect(lists));
        reportCommit(surfaces,all);
        cbvh::outdateThreadCaches();
        if (scene->isStaticAccel()) prims.clear();
        bvh->cleanup();
        bvh->postBuild(t0);
      }

    private:
      void setEmpty () {
        prims.clear();
        bvh->set(BVH4::emptyNode,empty,0);
      }

      struct Surface;

      /*! typical size, so that the allocator starts with blocks of a fitting size */
      static size_t estimateBytes (const std::vector<std::unique_ptr<Surface>>& surfaces)
      {
        size_t blocks = 0;
        for (const auto& surface : surfaces)
          blocks += parallel_reduce(size_t(0),surface->plan.mesh->size(),facesPerTask,size_t(0),[&](const range<size_t>& faces) {
              size_t n = 0;
              for (size_t f=faces.begin(); f!=faces.end(); f++) n += surface->estimateBlocks(f);
              return n;
            },std::plus<size_t>());
        return blocks*(sizeof(BVH4::AABBNode)/2 + cbvh::blockLayout(cbvh::kindLeaf,4).bytes);
      }

      /*! what the build knows of a geometry */
      struct Surface
      {
        CompressionPlan plan;
        std::unique_ptr<SharedVertices> shared; //!< of faces that share their borders, while it is needed
        mvector<unsigned char> frameLevel;      //!< by face; empty unless the plan bounds errors

        Surface (Scene* scene, SubdivMesh* mesh, unsigned geomID)
          : plan(scene,mesh,geomID), frameLevel(scene->device,plan.boundsError() ? mesh->size() : 0) {}

        void prepare (Scene* scene)
        {
          if (plan.sharesBorders()) {
            shared.reset(new SharedVertices(scene,plan));
            shared->build(facesPerTask);
          }
          if (plan.boundsError()) chooseFrameLevels(scene);
        }

        PatchTiling tilingOf (size_t f, const float rate[4]) const {
          return isa::tilingOf(plan.kind(),rate,plan.boundsError() ? frameLevel[f] : plan.frameLevel(levelOf(rate)));
        }

        /*! of a face, if no frame level follows from an error bound and no patch is stored exactly instead */
        size_t estimateBlocks (size_t face) const
        {
          if (!hasSurface(plan.mesh,face)) return 0;
          size_t n = 0;
          forEachPatch(plan.mesh,face,[&](const PatchOfFace& patch) {
              const CompressionPlan::Storage storage = plan.storage(patch.rate);
              if (storage == CompressionPlan::FRAMED) { n += isa::tilingOf(plan.kind(),patch.rate,plan.frameLevel(levelOf(patch.rate))).size(); return; }
              const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
              const unsigned side = storage == CompressionPlan::EXACT ? cbvh::vertBlockQuads : GridWriter::gridQuads;
              n += size_t(unsigned(size.x-2)/side+1)*size_t(unsigned(size.y-2)/side+1);
            });
          return n;
        }

        size_t bytesInGrid () const
        {
          return parallel_reduce(size_t(0),plan.mesh->size(),facesPerTask,size_t(0),[&](const range<size_t>& faces) {
              size_t bytes = 0;
              for (size_t f=faces.begin(); f!=faces.end(); f++)
                if (hasSurface(plan.mesh,f))
                  forEachPatch(plan.mesh,f,[&](const PatchOfFace& patch) {
                      bytes += CommitLine::bytesInGrid(SubdivPatch1Base::computeGridSize(patch.rate) - Vec2i(1));
                    });
              return bytes;
            },std::plus<size_t>());
        }

        template<typename Closure>
        void forEachPatchOf (size_t face, PatchGrid& grid, const Closure& closure) const
        {
          forEachPatch(plan.mesh,face,[&](const PatchOfFace& patch) {
              CagePatch ofCage(plan.mesh,plan.geomID,face,patch,shared.get(),grid);
              closure(ofCage);
            });
        }

      private:
        /*! the least levels that keep to the bound; asked once, as a displacement may answer differently */
        void chooseFrameLevels (Scene* scene)
        {
          parallel_for(size_t(0),frameLevel.size(),facesPerTask,[&](const range<size_t>& faces) {
              PatchGrid grid(scene->device);
              BlockStore nowhere(scene->device,Allocator(nullptr));
              cbvh::BuildStatistics ofTrials;
              FramedWriter trial(plan,scene,nowhere,ofTrials);
              size_t quads = 0;
              for (size_t f=faces.begin(); f!=faces.end(); f++)
              {
                unsigned n = 0;
                if (hasSurface(plan.mesh,f))
                  forEachPatchOf(f,grid,[&](SurfacePatch& patch) {
                      if (plan.storage(patch.rate) != CompressionPlan::FRAMED) return;
                      n = max(n,trial.boundedFrameLevel(patch));
                      quads += size_t(patch.quads[0])*size_t(patch.quads[1]);
                    });
                frameLevel[f] = (unsigned char)n;
                if (quads >= progressQuads) { scene->progressMonitor(0.0); quads = 0; }
              }
            });
        }
      };

      /*! primitives of the faces of a task, which begin with one */
      struct TaskPrims
      {
        unsigned geomID;
        size_t firstFace;
        std::shared_ptr<mvector<PrimRef>> prims;

        friend bool operator< (const TaskPrims& a, const TaskPrims& b) { return a.geomID != b.geomID ? a.geomID < b.geomID : a.firstFace < b.firstFace; }
      };

      void buildFaces (Surface& surface, cbvh::BuildStatistics& all, std::vector<TaskPrims>& lists)
      {
        surface.prepare(scene);
        const CompressionPlan& plan = surface.plan;
        cbvh::BuildStatistics total;
        MutexSys mutex;
        parallel_for(size_t(0),plan.mesh->size(),facesPerTask,[&](const range<size_t>& faces) {
            PatchGrid grid(scene->device);
            BlockStore store(scene->device,bvh->alloc.getCachedAllocator());
            cbvh::BuildStatistics statistics;
            FramedWriter framed(plan,scene,store,statistics);
            VertWriter exact(plan,scene->device,store,statistics);
            const GridWriter grids(scene,store,statistics);
            size_t reported = faces.begin(), quads = 0;
            for (size_t f=faces.begin(); f!=faces.end(); f++)
            {
              const size_t invalid = statistics.sums.numInvalidQuads;
              if (hasSurface(plan.mesh,f))
                surface.forEachPatchOf(f,grid,[&](SurfacePatch& patch) {
                    const size_t size = size_t(patch.quads[0])*size_t(patch.quads[1]);
                    switch (plan.storage(patch.rate)) {
                    case CompressionPlan::GRIDS:
                      grids.write(*patch.ofEmbree());
                      statistics.highRateQuads += plan.compresses() ? size : 0;
                      break;
                    case CompressionPlan::FRAMED:
                      if (!framed.write(patch,surface.tilingOf(f,patch.rate))) exact.write(patch,framed.evaluated(patch.quads[0],patch.quads[1]));
                      break;
                    case CompressionPlan::EXACT:
                      exact.write(patch,nullptr);
                      break;
                    }
                    quads += size;
                  });
              if (statistics.sums.numInvalidQuads != invalid) statistics.addInvalidFace(f);
              if (quads >= progressQuads || f+1 == faces.end()) {
                scene->progressMonitor(double(f+1-reported));
                reported = f+1;
                quads = 0;
              }
            }
            Lock<MutexSys> lock(mutex);
            total.merge(statistics);
            hitBounds.extend(store.hitBounds);
            lists.push_back(TaskPrims{ plan.geomID,faces.begin(),std::make_shared<mvector<PrimRef>>(std::move(store.prims)) });
          });
        reportAtVerbosity1(plan,total);
        /* a surface that did not change since the last commit was reported then */
        if (total.invalidFaces && scene->isGeometryModified(plan.geomID))
          report->errors.push_back(describeInvalid(plan,total));
        all.merge(total);
        surface.shared.reset();
      }

      void reportCommit (const std::vector<std::unique_ptr<Surface>>& surfaces, const cbvh::BuildStatistics& all) const
      {
        if (!scene->device->verbosity(1) && !environmentAsksForCommitLines()) return;
        CommitLine line;
        for (const auto& surface : surfaces)
          line.addGeometry(surface->plan.compresses(),surface->plan.compresses() ? surface->plan.kind() : cbvh::Kind::VERT,surface->bytesInGrid());
        Lock<MutexSys> lock(g_printMutex);
        std::cout << line.text(report->statistics,all) << std::endl;
      }

      /*! what of a compressed geometry is stored otherwise than asked for */
      void reportAtVerbosity1 (const CompressionPlan& plan, const cbvh::BuildStatistics& total) const
      {
        if (!scene->device->verbosity(1)) return;
        Lock<MutexSys> lock(g_printMutex);
        if (total.highRateQuads)
          std::cout << "compression: geometry " << plan.geomID << ": " << total.highRateQuads
                    << " quads of faces with edge rates above " << (plan.sharesBorders() ? cbvh::maxVertRate : 1u << cbvh::maxLevel) << " are traced by GRID" << std::endl;
        if (total.refusedQuads)
          std::cout << "compression: geometry " << plan.geomID << ": " << total.refusedQuads
                    << " quads of blocks that have no good frame (lines, outliers) keep full precision" << std::endl;
        if (total.sums.numExactQuads)
          std::cout << "compression: geometry " << plan.geomID << ": " << total.sums.numExactQuads
                    << " quads of faces that leaves hold badly (borders, creases, walls, folds) are stored as cVERT" << std::endl;
        if (total.sums.numRawBlocks)
          std::cout << "compression: geometry " << plan.geomID << ": " << total.sums.numRawBlocks
                    << " blocks of cVERT keep floats (a vertex that is not finite, a spacing too fine for their width, or a neighbour that GRID traces)" << std::endl;
        if (total.quadsForHoles)
          std::cout << "compression: geometry " << plan.geomID << ": " << total.quadsForHoles
                    << " quads of patches with holes are stored as cLEAF, as cVOXEL cannot leave a quad out" << std::endl;
      }

      static std::string describeInvalid (const CompressionPlan& plan, const cbvh::BuildStatistics& total)
      {
        return "geometry " + std::to_string(plan.geomID) + ", face " + std::to_string(total.firstInvalidFace) + ": vertices are not finite; left out of "
          + std::to_string(total.invalidFaces) + " face(s): " + std::to_string(total.sums.numInvalidQuads) + " quads";
      }

      /*! the lists of all tasks, in the order of their faces, whichever task was through first */
      PrimInfo collect (std::vector<TaskPrims>& lists)
      {
        std::sort(lists.begin(),lists.end());
        size_t n = 0;
        for (const TaskPrims& list : lists) n += list.prims->size();
        prims.resize(n);
        PrimInfo info(empty);
        n = 0;
        for (TaskPrims& list : lists) {
          for (const PrimRef& prim : *list.prims) { prims[n++] = prim; info.add_center2(prim); }
          list.prims.reset();
        }
        return PrimInfo(0,n,info);
      }

      void buildTopLevel (const PrimInfo& pinfo)
      {
        if (pinfo.size() == 0) { setEmpty(); return; }
        auto createLeaf = [&](const PrimRef* prims, const range<size_t>& range, Allocator) -> BVH4::NodeRef {
          return BVH4::NodeRef(size_t(prims[range.begin()].ID()));
        };
        /* faces are reported already: only give the monitor its say */
        auto progress = [&](size_t) { scene->progressMonitor(0.0); };
        auto virtualProgress = BuildProgressMonitorFromClosure(progress);

        GeneralBVHBuilder::Settings settings;
        settings.logBlockSize = bsr(4);
        settings.minLeafSize = 1;
        settings.maxLeafSize = 1;
        settings.travCost = 1.0f;
        settings.intCost = 1.0f;
        settings.singleThreadThreshold = DEFAULT_SINGLE_THREAD_THRESHOLD;
        const BVH4::NodeRef root = BVHNBuilderVirtual<4>::build(&bvh->alloc,createLeaf,virtualProgress,prims.data(),pinfo,settings);
        BBox3fa bounds = pinfo.geomBounds;
        if (!hitBounds.isEmpty()) bounds.extend(toBBox(hitBounds));
        bvh->set(root,LBBox3fa(bounds),pinfo.size());
        report->statistics.topLevelBytes = countNodes(root)*sizeof(BVH4::AABBNode);
        bvh->layoutLargeNodes(size_t(pinfo.size()*0.005f));
      }

      static size_t countNodes (BVH4::NodeRef ref)
      {
        if (ref == BVH4::emptyNode || !ref.isAABBNode()) return 0;
        size_t n = 1;
        for (size_t i=0; i<4; i++) n += countNodes(ref.getAABBNode()->child(i));
        return n;
      }
    };

    Builder* BVH4CompressedSubdivBuilder (void* bvh, Scene* scene, CompressionReport* report) {
      return new CompressedSubdivBuilder((BVH4*)bvh,scene,report);
    }
  }
}
