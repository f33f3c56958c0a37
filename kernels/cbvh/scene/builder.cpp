// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Builder of compressed subdivision surfaces: every task takes faces, tessellates
 * one patch at a time, encodes its blocks into the BVH's own memory and drops the
 * vertices. The top level is Embree's binned SAH BVH4 over the blocks' bounds.
 *
 * Patches with edge rates above 256 and geometries that opt out become GridSOA leaves
 * of the same BVH. */

#include "../../bvh/bvh_builder.h"
#include "../../builders/bvh_builder_sah.h"
#include "../framed/writer.h"
#include "../vert/writer.h"
#include "report.h"
#include "thread_cache.h"

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

        /* count, then build: every face knows where its primitives go */
        std::vector<std::unique_ptr<FaceTable>> tables;
        Scene::Iterator<SubdivMesh> meshes(scene);
        size_t numPrims = 0;
        for (size_t i=0; i<meshes.size(); i++) {
          if (meshes[i] == nullptr) continue;
          tables.emplace_back(new FaceTable(scene,meshes[i],unsigned(i)));
          tables.back()->count(scene);
          numPrims = tables.back()->prefixSum(numPrims);
        }
        if (numPrims == 0) { setEmpty(); bvh->postBuild(t0); return; }

        hitBounds = cbvh::WorldBounds();
        prims.resize(numPrims);
        bvh->alloc.init_estimate(estimateBytes(numPrims));
        cbvh::BuildStatistics all;
        for (auto& table : tables)
          buildFaces(*table,all);
        report->statistics = all.sums;

        buildTopLevel(compact());
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

      /*! typical size, so that the allocator starts with blocks of a fitting size */
      static size_t estimateBytes (size_t numPrims) {
        return numPrims*(sizeof(BVH4::AABBNode)/2 + cbvh::blockLayout(cbvh::kindLeaf,4).bytes);
      }

      /*! where the primitives of each face of a geometry go, and, if they follow from the
       *  geometry, its frame levels: asked once, as a displacement may answer differently */
      struct FaceTable
      {
        CompressionPlan plan;
        std::unique_ptr<SharedVertices> shared; //!< while it is needed
        mvector<size_t> offset;
        mvector<unsigned char> frameLevel; //!< empty unless the plan bounds errors

        FaceTable (Scene* scene, SubdivMesh* mesh, unsigned geomID)
          : plan(scene,mesh,geomID), offset(scene->device,mesh->size()), frameLevel(scene->device,plan.boundsError() ? mesh->size() : 0) {}

        void count (Scene* scene)
        {
          if (plan.boundsError()) shareBorders(scene);
          parallel_for(size_t(0),offset.size(),facesPerTask,[&](const range<size_t>& faces) {
              std::unique_ptr<PatchBuilder> trial;
              size_t quads = 0;
              for (size_t f=faces.begin(); f!=faces.end(); f++)
              {
                offset[f] = 0;
                if (!hasSurface(plan.mesh,f)) continue;
                if (plan.boundsError()) {
                  if (!trial) trial.reset(new PatchBuilder(plan,shared.get(),scene,Allocator(nullptr)));
                  frameLevel[f] = boundedFrameLevel(f,*trial,quads);
                  if (quads >= progressQuads) { scene->progressMonitor(0.0); quads = 0; }
                }
                forEachPatch(plan.mesh,f,[&](const PatchOfFace& patch) {
                    const PatchTiling tiling = tilingOf(f,patch.rate);
                    offset[f] += tiling.size() ? room(patch.rate,tiling)
                                               : PatchBuilder::numGrids(SubdivPatch1Base::computeGridSize(patch.rate));
                  });
              }
            });
        }

        void shareBorders (Scene* scene)
        {
          if (shared || !plan.sharesBorders()) return;
          shared.reset(new SharedVertices(scene,plan));
          shared->build(facesPerTask);
        }

        PatchTiling tilingOf (size_t f, const float rate[4]) const {
          return plan.tiling(rate,plan.boundsError() ? frameLevel[f] : plan.frameLevel(plan.level(rate)));
        }

        /*! primitives of a patch at most, which may turn out to be stored exactly */
        size_t room (const float rate[4], const PatchTiling& tiling) const {
          return plan.hasExactFaces() ? max(tiling.size(),plan.exactTiling(rate).size()) : tiling.size();
        }

        /*! counts become offsets; returns where they end */
        size_t prefixSum (size_t begin)
        {
          for (size_t f=0; f<offset.size(); f++) {
            const size_t n = offset[f];
            offset[f] = begin;
            begin += n;
          }
          return begin;
        }

      private:
        unsigned char boundedFrameLevel (size_t f, PatchBuilder& trial, size_t& quads) const
        {
          unsigned n = 0;
          forEachPatch(plan.mesh,f,[&](const PatchOfFace& patch) {
              const PatchTiling tiling = plan.tiling(patch.rate,0);
              if (tiling.size() == 0) return;
              n = max(n,trial.boundedFrameLevel(f,patch));
              quads += size_t(tiling.quadsX())*size_t(tiling.quadsY());
            });
          return (unsigned char)n;
        }
      };

      void buildFaces (FaceTable& table, cbvh::BuildStatistics& all)
      {
        const CompressionPlan& plan = table.plan;
        table.shareBorders(scene);
        const SharedVertices* shared = table.shared.get();
        cbvh::BuildStatistics total;
        MutexSys mutex;
        parallel_for(size_t(0),table.offset.size(),facesPerTask,[&](const range<size_t>& faces) {
            PatchBuilder builder(plan,shared,scene,bvh->alloc.getCachedAllocator());
            std::unique_ptr<VertPatchBuilder> vertBuilder;
            if (shared) vertBuilder.reset(new VertPatchBuilder(plan,*shared,scene,bvh->alloc.getCachedAllocator()));
            auto invalidQuads = [&]() { return builder.statistics.sums.numInvalidQuads + (vertBuilder ? vertBuilder->statistics.sums.numInvalidQuads : 0); };
            size_t reported = faces.begin(), quads = 0;
            for (size_t f=faces.begin(); f!=faces.end(); f++)
            {
              PrimRef* out = prims.data() + table.offset[f];
              const size_t invalid = invalidQuads();
              if (hasSurface(plan.mesh,f))
                forEachPatch(plan.mesh,f,[&](const PatchOfFace& patch) {
                    const PatchTiling tiling = table.tilingOf(f,patch.rate);
                    if (tiling.size() == 0) { out += builder.buildGrids(patch.make(plan.mesh,plan.geomID,f),out); }
                    else {
                      PrimRef* const begin = out;
                      const PatchTiling exact = plan.exactTiling(patch.rate);
                      const float (*evaluated)[3] = nullptr;
                      if (plan.kind() != cbvh::Kind::VERT) {
                        out += builder.buildBlocks(f,patch,tiling,out);
                        evaluated = builder.evaluated(exact.quadsX(),exact.quadsY());
                      }
                      if (out == begin) out += vertBuilder->buildBlocks(f,patch,exact,evaluated,out);
                      while (out < begin+table.room(patch.rate,tiling)) *out++ = PatchBuilder::dropped();
                    }
                    const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
                    quads += size_t(size.x-1)*size_t(size.y-1);
                  });
              if (invalidQuads() != invalid) builder.statistics.addInvalidFace(f);
              if (quads >= progressQuads || f+1 == faces.end()) {
                scene->progressMonitor(double(f+1-reported));
                reported = f+1;
                quads = 0;
              }
            }
            Lock<MutexSys> lock(mutex);
            total.merge(builder.statistics);
            hitBounds.extend(builder.hitBounds);
            if (vertBuilder) { total.merge(vertBuilder->statistics); hitBounds.extend(vertBuilder->hitBounds); }
          });
        tell(plan,total);
        /* a surface that did not change since the last commit was reported then */
        if (total.invalidFaces && scene->isGeometryModified(plan.geomID))
          report->errors.push_back(describeInvalid(plan,total));
        all.merge(total);
        table.shared.reset();
      }

      /*! says at verbosity 1 what of a compressed geometry GRID traces */
      void tell (const CompressionPlan& plan, const cbvh::BuildStatistics& total) const
      {
        if (!scene->device->verbosity(1)) return;
        Lock<MutexSys> lock(g_printMutex);
        if (total.highRateQuads)
          std::cout << "compression: geometry " << plan.geomID << ": " << total.highRateQuads
                    << " quads of faces with edge rates above 256 are traced by GRID" << std::endl;
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

      /*! closes the gaps that dropped blocks left */
      PrimInfo compact ()
      {
        PrimInfo info(empty);
        size_t n = 0;
        for (size_t i=0; i<prims.size(); i++)
          if (!PatchBuilder::isDropped(prims[i])) { prims[n++] = prims[i]; info.add_center2(prims[i]); }
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
