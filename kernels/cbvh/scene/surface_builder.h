// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds the blocks of one geometry. Every task takes faces, or a strip of a large patch, tessellates it, encodes its blocks into the
 * surface's own memory and drops the vertices. Above them comes Embree's binned SAH BVH4, whose lower trees are what scenes build theirs of.
 *
 * Patches with edge rates that no block takes, and geometries that opt out, become GridSOA leaves of the same BVH. */

#include "../base/tasks.h"
#include "../framed/writer.h"
#include "../surface/cage_patch.h"
#include "../vert/writer.h"
#include "surface_blocks.h"
#include "tree.h"
#include <tuple>

namespace embree
{
  namespace isa
  {
    class SurfaceBuilder
    {
    public:
      SurfaceBuilder (SubdivMesh* mesh, const std::shared_ptr<const cbvh::SurfaceNumber>& number)
        : mesh(mesh), device(mesh->device), number(number), plan(mesh,*number), estimatedBlocks(estimateBlocks()),
          facesPerTask(isSmall() ? max(mesh->size(),size_t(1)) : clamp(mesh->size()/(4*TaskScheduler::threadCount()),size_t(1),size_t(8))),
          frameLevel(device,plan.boundsError() ? mesh->size() : 0) {}

      /*! whether it is built in no time, and takes no memory worth mention meanwhile */
      bool isSmall () const { return estimatedBlocks <= isa::blocksOfPart; }

      /*! whether it takes all threads, and memory worth mention meanwhile */
      bool isLarge () const { return estimatedBlocks > 4096; }

      /*! progress(faces): faces that are through, or 0; it may throw, which ends the build */
      template<typename Progress>
      std::shared_ptr<const SurfaceBlocks> build (const Progress& progress)
      {
        std::shared_ptr<SurfaceBlocks> blocks = std::make_shared<SurfaceBlocks>(device,number);
        blocks->memory.expect(isSmall() ? 0 : estimatedBlocks*(sizeof(BVH4::AABBNode)/2 + cbvh::blockLayout(cbvh::kindLeaf,4).bytes));
        if (plan.sharesBorders()) {
          shared.reset(new SharedVertices(plan));
          shared->build(facesPerTask,[&] { progress(0.0); });
        }
        if (plan.boundsError()) chooseFrameLevels(progress);
        mvector<PrimRef> prims(device,0);
        buildFaces(*blocks,prims,progress);
        shared.reset();
        buildTree(*blocks,prims,progress);
        blocks->memory.end();
        return blocks;
      }

    private:
      /*! how often, in quads, a task reports progress: enough to cancel, too seldom to be felt */
      static const size_t progressQuads = 1 << 15;

      /*! if no frame level follows from an error bound and no patch is stored exactly instead */
      size_t estimateBlocks () const
      {
        return reduceRanges(mesh->size(),size_t(64),size_t(0),[&](const range<size_t>& faces) {
            size_t n = 0;
            for (size_t f=faces.begin(); f!=faces.end(); f++)
              if (hasSurface(mesh,f))
                forEachPatch(mesh,f,[&](const PatchOfFace& patch) { n += estimateBlocks(patch); });
            return n;
          },std::plus<size_t>());
      }

      size_t estimateBlocks (const PatchOfFace& patch) const
      {
        const CompressionPlan::Storage storage = plan.storage(patch.rate);
        if (storage == CompressionPlan::FRAMED) return isa::tilingOf(plan.kind(),patch.rate,plan.frameLevel(levelOf(patch.rate))).size();
        const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
        const unsigned side = storage == CompressionPlan::EXACT ? cbvh::vertBlockQuads : GridWriter::gridQuads;
        return size_t(unsigned(size.x-2)/side+1)*size_t(unsigned(size.y-2)/side+1);
      }

      PatchTiling tilingOf (size_t f, const float rate[4]) const {
        return isa::tilingOf(plan.kind(),rate,plan.boundsError() ? frameLevel[f] : plan.frameLevel(levelOf(rate)));
      }

      template<typename Closure>
      void forEachPatchOf (size_t face, PatchGrid& grid, const Closure& closure) const
      {
        forEachPatch(mesh,face,[&](const PatchOfFace& patch) {
            CagePatch ofCage(mesh,plan.surface,face,patch,shared.get(),grid);
            closure(ofCage);
          });
      }

      /*! the least levels that keep to the bound; asked once, as a displacement may answer differently */
      template<typename Progress>
      void chooseFrameLevels (const Progress& progress)
      {
        forRanges(frameLevel.size(),facesPerTask,[&](const range<size_t>& faces) {
            PatchGrid grid(device);
            BlockStore nowhere(device,nullptr);
            cbvh::BuildStatistics ofTrials;
            FramedWriter trial(plan,device,nowhere,ofTrials);
            size_t quads = 0;
            for (size_t f=faces.begin(); f!=faces.end(); f++)
            {
              unsigned n = 0;
              if (hasSurface(mesh,f))
                forEachPatchOf(f,grid,[&](SurfacePatch& patch) {
                    if (plan.storage(patch.rate) != CompressionPlan::FRAMED) return;
                    n = max(n,trial.boundedFrameLevel(patch));
                    quads += size_t(patch.quads[0])*size_t(patch.quads[1]);
                  });
              frameLevel[f] = (unsigned char)n;
              if (quads >= progressQuads) { progress(0.0); quads = 0; }
            }
          });
      }

      /*! what tasks leave behind, together */
      struct Results
      {
        /*! Primitives of faces, or of strips of a patch, which begin with one. */
        struct List
        {
          size_t face;
          unsigned patch, strip;
          mvector<PrimRef> prims;

          bool operator< (const List& other) const { return std::tie(face,patch,strip) < std::tie(other.face,other.patch,other.strip); }
        };

        std::vector<std::unique_ptr<List>> lists;
        cbvh::BuildStatistics statistics;
        cbvh::WorldBounds hitBounds;
        MutexSys mutex;

        void add (size_t face, unsigned patch, unsigned strip, BlockStore& store)
        {
          Lock<MutexSys> lock(mutex);
          hitBounds.extend(store.hitBounds);
          if (store.prims.size()) lists.emplace_back(new List{ face,patch,strip,std::move(store.prims) });
        }

        void add (const cbvh::BuildStatistics& ofTask)
        {
          Lock<MutexSys> lock(mutex);
          statistics.merge(ofTask);
        }
      };

      template<typename Progress>
      void buildFaces (SurfaceBlocks& blocks, mvector<PrimRef>& prims, const Progress& progress)
      {
        Results results;
        forRanges(mesh->size(),facesPerTask,[&](const range<size_t>& faces) { buildFaces(faces,blocks.memory,results,progress); });
        blocks.statistics = results.statistics;
        blocks.bounds = results.hitBounds.isEmpty() ? BBox3fa(empty) : toBBox(results.hitBounds);
        collect(results.lists,prims);
      }

      template<typename Progress>
      void buildFaces (const range<size_t>& faces, cbvh::BlockMemory& memory, Results& results, const Progress& progress)
      {
        PatchGrid grid(device);
        BlockStore store(device,&memory);
        cbvh::BuildStatistics statistics;
        FramedWriter framed(plan,device,store,statistics);
        VertWriter exact(plan,device,store,statistics);
        const GridWriter grids(mesh,store,statistics);
        size_t reported = faces.begin(), quads = 0, firstFace = faces.begin();
        unsigned firstPatch = 0; // of those whose primitives the store has
        for (size_t f=faces.begin(); f!=faces.end(); f++)
        {
          const size_t invalid = statistics.sums.numInvalidQuads;
          unsigned patchOfFace = 0;
          if (hasSurface(mesh,f))
            forEachPatchOf(f,grid,[&](CagePatch& patch) {
                const size_t size = size_t(patch.quads[0])*size_t(patch.quads[1]);
                switch (plan.storage(patch.rate)) {
                case CompressionPlan::GRIDS:
                  grids.write(*patch.ofEmbree());
                  statistics.highRateQuads += plan.compresses() ? size : 0;
                  break;
                case CompressionPlan::FRAMED:
                  if (!framed.write(patch,tilingOf(f,patch.rate))) exact.write(patch,framed.evaluated(patch.quads[0],patch.quads[1]));
                  break;
                case CompressionPlan::EXACT:
                  if (patch.quads[1] <= VertWriter::rowsOfStrip(patch)) { exact.write(patch,patch.evaluated()); break; }
                  results.add(firstFace,firstPatch,0,store);
                  buildStrips(f,patchOfFace,patch,memory,results,statistics,progress);
                  firstFace = f;
                  firstPatch = patchOfFace+1;
                  break;
                }
                statistics.bytesInGrid += GridWriter::bytesInGrid(Vec2i(int(patch.quads[0]),int(patch.quads[1])));
                quads += size;
                patchOfFace++;
              });
          if (statistics.sums.numInvalidQuads != invalid) statistics.addInvalidFace(f);
          if (quads >= progressQuads || f+1 == faces.end()) {
            progress(double(f+1-reported));
            reported = f+1;
            quads = 0;
          }
        }
        results.add(firstFace,firstPatch,0,store);
        results.add(statistics);
      }

      /*! A patch of so many quads that several tasks write it. */
      template<typename Progress>
      void buildStrips (size_t face, unsigned patchOfFace, const CagePatch& patch, cbvh::BlockMemory& memory, Results& results,
                        cbvh::BuildStatistics& statistics, const Progress& progress)
      {
        const unsigned rows = VertWriter::rowsOfStrip(patch), quadsX = patch.quads[0], quadsY = patch.quads[1], strips = (quadsY+rows-1)/rows;
        const size_t width = quadsX+1;
        mvector<float> seams(device,3*width*(strips-1)); // rows between strips
        auto seam = [&](unsigned s) { return (float(*)[3])(seams.data() + 3*width*s); };
        parallel_for(1u,strips,1u,[&](const range<unsigned>& r) {
            PatchGrid grid(device);
            CagePatch own(patch,grid);
            for (unsigned s=r.begin(); s!=r.end(); s++)
              memcpy(seam(s-1),own.evaluate(quadsX,quadsY,PatchPart{ 0,quadsX,s*rows,s*rows },0).displaced(),width*sizeof(float[3]));
          });
        MutexSys mutex;
        parallel_for(0u,strips,1u,[&](const range<unsigned>& r) {
            PatchGrid grid(device);
            CagePatch own(patch,grid);
            cbvh::BuildStatistics ofStrips;
            for (unsigned s=r.begin(); s!=r.end(); s++) {
              BlockStore store(device,&memory);
              const PatchPart strip = { 0,quadsX,s*rows,min((s+1)*rows,quadsY) };
              VertWriter(plan,device,store,ofStrips).write(own,strip,s == 0 ? nullptr : seam(s-1),s+1 == strips ? nullptr : seam(s));
              results.add(face,patchOfFace,s+1,store);
              progress(0.0);
            }
            Lock<MutexSys> lock(mutex);
            statistics.merge(ofStrips);
          });
      }

      /*! the lists of all tasks, in the order of their faces, whichever task was through first */
      static void collect (std::vector<std::unique_ptr<Results::List>>& lists, mvector<PrimRef>& prims)
      {
        std::sort(lists.begin(),lists.end(),[](const std::unique_ptr<Results::List>& a, const std::unique_ptr<Results::List>& b) { return *a < *b; });
        size_t n = 0;
        for (const auto& list : lists) n += list->prims.size();
        prims.resize(n);
        n = 0;
        for (auto& list : lists) {
          for (const PrimRef& prim : list->prims) prims[n++] = prim;
          list.reset();
        }
      }

      /*! few primitives are left to the trees of scenes */
      template<typename Progress>
      void buildTree (SurfaceBlocks& blocks, mvector<PrimRef>& prims, const Progress& progress)
      {
        blocks.numPrimitives = prims.size();
        for (const PrimRef& prim : prims) blocks.bounds.extend(prim.bounds());
        if (!blocks.memory.pool() || prims.size() <= isa::blocksOfPart) { blocks.parts = std::move(prims); return; }
        size_t nodes = 0;
        FastAllocator& memory = *blocks.memory.pool();
        blocks.root = isa::moveLargestNodes(isa::buildTree(memory,prims,[&] { progress(0.0); },nodes),nodes,memory);
        blocks.statistics.sums.topLevelBytes = nodes*sizeof(BVH4::AABBNode);
        isa::TreeCutter(blocks.parts).cut(blocks.root,blocks.bounds);
      }

      SubdivMesh* mesh;
      Device* device;
      const std::shared_ptr<const cbvh::SurfaceNumber> number;
      const CompressionPlan plan;
      const size_t estimatedBlocks;
      const size_t facesPerTask;              //!< a face is worth milliseconds at high levels, and those of one geometry may differ a lot; of small ones all
      mvector<unsigned char> frameLevel;      //!< by face; empty unless the plan bounds errors
      std::unique_ptr<SharedVertices> shared; //!< of faces that share their borders, while it is needed
    };
  }
}
