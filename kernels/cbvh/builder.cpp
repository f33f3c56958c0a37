// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Builder of compressed subdivision surfaces: every task takes faces, tessellates
 * one patch at a time, encodes its blocks into the BVH's own memory and drops the
 * vertices. The top level is Embree's binned SAH BVH4 over the blocks' bounds.
 *
 * Patches that cannot be compressed (edge rates that differ or are not a power of
 * two) and geometries that opt out become GridSOA leaves of the same BVH. */

#include "../bvh/bvh.h"
#include "../bvh/bvh_builder.h"
#include "../builders/primrefgen.h"
#include "../builders/bvh_builder_sah.h"
#include "../../common/algorithms/parallel_for_for.h"
#include "../../common/algorithms/parallel_for_for_prefix_sum.h"
#include "../geometry/grid_soa.h"
#include "patch_grid.h"
#include "top_level.h"
#include "statistics.h"

namespace embree
{
  namespace isa
  {
    using cbvh::Block;
    using cbvh::BlockEncoder;
    using cbvh::BlockLayout;
    using cbvh::BlockStatistics;
    using cbvh::BuildStatistics;

    typedef FastAllocator::CachedAllocator Allocator;

    /*! memory that a task reuses from patch to patch */
    struct BuildScratch
    {
      BuildScratch (Device* device) : grid(device), vertices(device,0), encoder(device,0) {}

      PatchGrid grid;
      mvector<float> vertices; //!< of one block
      mvector<Vec3fa> encoder; //!< the encoder's, aligned
    };

    class CompressedSubdivBuilder : public Builder
    {
      ALIGNED_CLASS_(64);

      /*! GRID cuts patches into grids of 8 x 8 quads */
      static const unsigned gridQuads = 8;

      /*! memory of a patch's blocks is taken in pieces of at most this */
      static const size_t maxPieceBytes = 1 << 18;

      BVH4* bvh;
      Scene* scene;
      BuildStatistics* statistics;
      mvector<PrimRef> prims;
      MutexSys statisticsMutex;
      std::atomic<size_t> numDropped; //!< blocks without a single finite quad

    public:
      CompressedSubdivBuilder (BVH4* bvh, Scene* scene, BuildStatistics* statistics)
        : bvh(bvh), scene(scene), statistics(statistics), prims(scene->device,0), numDropped(0) {}

      void clear () { prims.clear(); }

      void build ()
      {
        *statistics = BuildStatistics();
        numDropped = 0;
        const size_t numFaces = scene->getNumPrimitives(SubdivMesh::geom_type,false);
        if (numFaces == 0) { setEmpty(); return; }
        const double t0 = bvh->preBuild(TOSTRING(isa) "::BVH4CompressedSubdivBuilder");

        /* count, then build: every task knows where its blocks go */
        Scene::Iterator<SubdivMesh> meshes(scene);
        ParallelForForPrefixSumState<PrimInfo> state;
        state.init(meshes,size_t(1));
        const PrimInfo counts = parallel_for_for_prefix_sum0(state,meshes,PrimInfo(empty),[&](SubdivMesh* mesh, const range<size_t>& faces, size_t, size_t) -> PrimInfo {
            return PrimInfo(0,countPrims(mesh,faces),empty);
          }, [](const PrimInfo& a, const PrimInfo& b) { return PrimInfo(0,a.end+b.end,empty); });
        if (counts.end == 0) { setEmpty(); bvh->postBuild(t0); return; }

        prims.resize(counts.end);
        bvh->alloc.init_estimate(estimateBytes(counts.end));
        PrimInfo pinfo = parallel_for_for_prefix_sum1(state,meshes,PrimInfo(empty),[&](SubdivMesh* mesh, const range<size_t>& faces, size_t, size_t geomID, const PrimInfo& base) -> PrimInfo {
            return buildFaces(mesh,unsigned(geomID),faces,&prims[base.end]);
          }, [](const PrimInfo& a, const PrimInfo& b) { return PrimInfo::merge(a,b); });
        pinfo = PrimInfo(0,pinfo.end,pinfo);
        if (numDropped) pinfo = compact(counts.end);

        buildTopLevel(pinfo);
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
      size_t estimateBytes (size_t numPrims) const {
        return numPrims*(sizeof(BVH4::AABBNode)/2 + BlockLayout(cbvh::Kind::LEAF,4).bytes);
      }

      CompressionSettings settingsOf (const SubdivMesh* mesh) const {
        return mesh->compression.resolve(scene->device->compression);
      }

      static cbvh::Kind kindOf (const CompressionSettings& settings)
      {
        switch (settings.compression) {
        case RTC_COMPRESSION_GRID : return cbvh::Kind::GRID;
        case RTC_COMPRESSION_VOXEL: return cbvh::Kind::VOXEL;
        default: return cbvh::Kind::LEAF;
        }
      }

      /*! level of a patch whose four edges have the rate 2^level; -1 for any other */
      static int uniformLevel (const float rate[4])
      {
        if (rate[0] != rate[1] || rate[0] != rate[2] || rate[0] != rate[3]) return -1;
        for (unsigned level=0; level<=cbvh::maxLevel; level++)
          if (rate[0] == float(1u << level)) return int(level);
        return -1;
      }

      /*! level of a patch that gets compressed, -1 for one that GRID traces */
      static int compressedLevel (const CompressionSettings& settings, const float rate[4]) {
        return settings.compression == RTC_COMPRESSION_NONE ? -1 : uniformLevel(rate);
      }

      static unsigned numGrids (Vec2i resolution) {
        return ((resolution.x-2)/gridQuads + 1)*((resolution.y-2)/gridQuads + 1);
      }

      /*! frame level of a patch without an error bound */
      static unsigned frameLevel (const CompressionSettings& settings, unsigned level) {
        const unsigned n = settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO ? (level > 4 ? level-4 : 0) : unsigned(settings.frameLevel);
        return min(n,level);
      }

      static bool boundsError (const CompressionSettings& settings) {
        return settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO && settings.maxError > 0.0f && settings.compression != RTC_COMPRESSION_GRID;
      }

      template<typename Closure>
      void forEachPatch (SubdivMesh* mesh, size_t face, const Closure& closure) const
      {
        patch_eval_subdivision(mesh->getHalfEdge(0,face),[&](const Vec2f uv[4], const int subdiv[4], const float edgeLevel[4], int subPatch) {
            float rate[4];
            SubdivPatch1Base::computeEdgeLevels(edgeLevel,subdiv,rate);
            closure(uv,subdiv,edgeLevel,subPatch,rate);
          });
      }

      size_t countPrims (SubdivMesh* mesh, const range<size_t>& faces) const
      {
        const CompressionSettings settings = settingsOf(mesh);
        size_t count = 0;
        std::unique_ptr<BuildScratch> scratch;
        for (size_t f=faces.begin(); f!=faces.end(); f++)
        {
          if (!mesh->valid(f)) continue;
          forEachPatch(mesh,f,[&](const Vec2f uv[4], const int subdiv[4], const float edgeLevel[4], int subPatch, const float rate[4]) {
              const int level = compressedLevel(settings,rate);
              if (level < 0) { count += numGrids(SubdivPatch1Base::computeGridSize(rate)); return; }
              unsigned n = frameLevel(settings,unsigned(level));
              if (boundsError(settings)) {
                if (!scratch) scratch.reset(new BuildScratch(scene->device));
                const SubdivPatch1Base patch(0,unsigned(f),unsigned(subPatch),mesh,0,uv,edgeLevel,subdiv,VSIZEX);
                scratch->grid.eval(patch,mesh);
                n = boundedFrameLevel(settings,unsigned(level),*scratch);
              }
              count += size_t(1) << (2*n);
            });
        }
        return count;
      }

      PrimInfo buildFaces (SubdivMesh* mesh, unsigned geomID, const range<size_t>& faces, PrimRef* out)
      {
        const CompressionSettings settings = settingsOf(mesh);
        Allocator alloc = bvh->alloc.getCachedAllocator();
        BuildScratch scratch(scene->device);
        BuildStatistics stats;
        PrimInfo info(empty);
        size_t reported = faces.begin(), quads = 0;
        for (size_t f=faces.begin(); f!=faces.end(); f++)
        {
          if (mesh->valid(f))
            forEachPatch(mesh,f,[&](const Vec2f uv[4], const int subdiv[4], const float edgeLevel[4], int subPatch, const float rate[4]) {
                const SubdivPatch1Base patch(geomID,unsigned(f),unsigned(subPatch),mesh,0,uv,edgeLevel,subdiv,VSIZEX);
                const int level = compressedLevel(settings,rate);
                const size_t n = level < 0 ? buildGrids(patch,alloc,out,stats) : buildBlocks(patch,mesh,settings,unsigned(level),alloc,scratch,out,stats);
                for (size_t i=0; i<n; i++, out++)
                  if (!isDropped(*out)) info.add_center2(*out);
                quads += size_t(patch.grid_u_res-1)*size_t(patch.grid_v_res-1);
              });
          /* often enough to cancel, seldom enough not to be felt */
          if (quads >= (1 << 15) || f+1 == faces.end()) {
            scene->progressMonitor(double(f+1-reported));
            reported = f+1;
            quads = 0;
          }
        }
        Lock<MutexSys> lock(statisticsMutex);
        if (settings.compression != RTC_COMPRESSION_NONE && stats.numGridQuads && scene->device->verbosity(1))
          std::cout << "compression: geometry " << geomID << ": " << stats.numGridQuads
                    << " quads of faces whose edge rates are not one power of two up to 256 are traced by GRID" << std::endl;
        statistics->merge(stats);
        return info;
      }

      /*! patch as stock Embree has it */
      size_t buildGrids (const SubdivPatch1Base& patch, Allocator& alloc, PrimRef* out, BuildStatistics& stats)
      {
        size_t n = 0;
        const unsigned x1 = patch.grid_u_res-1, y1 = patch.grid_v_res-1;
        for (unsigned y=0; y<y1; y+=gridQuads)
          for (unsigned x=0; x<x1; x+=gridQuads)
            out[n++] = createGrid(patch,x,min(x+gridQuads,x1),y,min(y+gridQuads,y1),alloc,stats);
        return n;
      }

      PrimRef createGrid (const SubdivPatch1Base& patch, unsigned x0, unsigned x1, unsigned y0, unsigned y1, Allocator& alloc, BuildStatistics& stats)
      {
        BBox3fa bounds;
        GridSOA* grid = GridSOA::create(&patch,1,x0,x1,y0,y1,scene,alloc,&bounds);
        stats.gridBytes += offsetof(GridSOA,data) + grid->rootOffset + sizeof(BVH4::NodeRef);
        stats.numGridQuads += size_t(x1-x0)*size_t(y1-y0);
        return PrimRef(bounds,size_t(BVH4::encodeTypedLeaf(grid,cbvh::GRID_SOA_ROOT)));
      }

      /*! vertices of block (x,y), and the corners its frame aligns to */
      void gatherBlock (const CompressionSettings& settings, unsigned height, unsigned x, unsigned y, BuildScratch& scratch, float corners[4][3]) const
      {
        const size_t w = (size_t(1) << height) + 1;
        const size_t x0 = size_t(x) << height, y0 = size_t(y) << height;
        PatchGrid& grid = scratch.grid;
        scratch.vertices.resize(3*w*w);
        scratch.encoder.resize((BlockEncoder::scratchBytes(height)+sizeof(Vec3fa)-1)/sizeof(Vec3fa));
        for (size_t r=0; r<w; r++)
          memcpy(&scratch.vertices[3*r*w],grid.displaced()[(y0+r)*grid.width+x0],3*w*sizeof(float));
        /* heights are best stored along the normal of the smooth surface; boxes are
         * tightest around what they bound */
        float (*aligned)[3] = settings.compression == RTC_COMPRESSION_LEAF ? grid.undisplaced() : grid.displaced();
        for (size_t c=0; c<4; c++)
          memcpy(corners[c],aligned[(y0 + (c>>1)*(w-1))*grid.width + x0 + (c&1)*(w-1)],sizeof(float[3]));
      }

      /*! smallest frame level at which no leaf of the patch is thicker than the bound */
      unsigned boundedFrameLevel (const CompressionSettings& settings, unsigned level, BuildScratch& scratch) const
      {
        const cbvh::Kind kind = kindOf(settings);
        mvector<Vec3fa> memory(scene->device,BlockLayout(kind,level).bytes/sizeof(Vec3fa)+1);
        for (unsigned n=0; n<level; n++)
        {
          const unsigned height = level-n;
          BlockStatistics worst;
          for (unsigned i=0; i < 1u << (2*n) && worst.maxThickness <= settings.maxError; i++)
          {
            float corners[4][3];
            gatherBlock(settings,height,cbvh::mortonX(i),cbvh::mortonY(i),scratch,corners);
            BlockEncoder encoder(kind,height,(float(*)[3])scratch.vertices.data(),scratch.encoder.data());
            if (encoder.fit(corners)) encoder.encode((Block*)memory.data(),level,0,0,worst);
          }
          if (worst.maxThickness <= settings.maxError) return n;
        }
        return level;
      }

      size_t buildBlocks (const SubdivPatch1Base& patch, SubdivMesh* mesh, const CompressionSettings& settings, unsigned level,
                          Allocator& alloc, BuildScratch& scratch, PrimRef* out, BuildStatistics& stats)
      {
        scratch.grid.eval(patch,mesh);
        /* a node has no code for a child without surface: where quads are left out, leaves say so */
        const bool hasHoles = !scratch.grid.isFinite();
        const cbvh::Kind kind = kindOf(settings) == cbvh::Kind::VOXEL && hasHoles ? cbvh::Kind::LEAF : kindOf(settings);
        const unsigned n = boundsError(settings) ? boundedFrameLevel(settings,level,scratch) : frameLevel(settings,level);
        const unsigned height = level-n;
        const size_t count = size_t(1) << (2*n);
        /* one piece of memory a patch: small pieces cost the allocator's rounding each;
         * several for a large patch, as it takes none above 2 MiB */
        const size_t stride = BlockLayout(kind,height).stride();
        const size_t piece = max(maxPieceBytes/stride,size_t(1));
        char* memory = nullptr;
        for (unsigned i=0; i<count; i++) {
          if (i % piece == 0) memory = (char*)alloc.malloc1(min(piece,count-i)*stride,BlockLayout::alignment);
          out[i] = createBlock(patch,settings,kind,level,height,cbvh::mortonX(i),cbvh::mortonY(i),(Block*)(memory+(i%piece)*stride),alloc,scratch,stats);
        }
        return count;
      }

      PrimRef createBlock (const SubdivPatch1Base& patch, const CompressionSettings& settings, cbvh::Kind kind, unsigned level, unsigned height,
                           unsigned x, unsigned y, Block* block, Allocator& alloc, BuildScratch& scratch, BuildStatistics& stats)
      {
        float corners[4][3];
        gatherBlock(settings,height,x,y,scratch,corners);
        const float (*vertices)[3] = (const float(*)[3])scratch.vertices.data();
        const size_t width = (size_t(1) << height) + 1;
        BBox3fa bounds(empty);
        bool allFinite = true;
        for (size_t i=0; i<width*width; i++) {
          const Vec3fa p(vertices[i][0],vertices[i][1],vertices[i][2]);
          if (isvalid(p)) bounds.extend(p); else allFinite = false;
        }

        BlockEncoder encoder(kind,height,vertices,scratch.encoder.data());
        if (bounds.empty() || !encoder.fit(corners))
        {
          /* floats hold the vertices but no frame of theirs */
          if (allFinite && !bounds.empty()) {
            const unsigned quads = 1u << height;
            return createGrid(patch,x*quads,(x+1)*quads,y*quads,(y+1)*quads,alloc,stats);
          }
          stats.numInvalidQuads += size_t(1) << (2*height);
          numDropped++;
          return droppedPrim();
        }

        BlockStatistics blockStats;
        encoder.encode(block,level,x,y,blockStats);
        block->geomID = patch.geomID();
        block->primID = patch.primID();
        block->u0 = patch.u[0];
        block->v0 = patch.v[0];
        stats.addBlock(kind,height,blockStats);
        return PrimRef(bounds,size_t(BVH4::encodeTypedLeaf(block,cbvh::leafType(kind))));
      }

      static PrimRef droppedPrim () { return PrimRef(BBox3fa(Vec3fa(zero),Vec3fa(zero)),size_t(0)); }
      static bool isDropped (const PrimRef& prim) { return prim.ID() == 0; }

      PrimInfo compact (size_t count)
      {
        PrimInfo info(empty);
        size_t n = 0;
        for (size_t i=0; i<count; i++)
          if (!isDropped(prims[i])) { prims[n++] = prims[i]; info.add_center2(prims[i]); }
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
        bvh->set(root,LBBox3fa(pinfo.geomBounds),pinfo.size());
        statistics->topLevelBytes = countNodes(root)*sizeof(BVH4::AABBNode);
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

    Builder* BVH4CompressedSubdivBuilder (void* bvh, Scene* scene, BuildStatistics* statistics) {
      return new CompressedSubdivBuilder((BVH4*)bvh,scene,statistics);
    }
  }
}
