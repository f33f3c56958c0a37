// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "quad_regions.h"
#include "../../cvert/format/block.h"
#include "embree_bytes.h"
#include "quad_neighbors.h"
#include "triangle_pairs.h"

namespace embree {
namespace {
/*! Finds regions greedily. A quad is free until it is in a region. A region grows from a seed to the right and up,
 *  by a column or row at a time, as square as it can. The first seeds are corners: quads with no free quad on the
 *  left and none below. Large regions come first, so that a row of quads at a pole does not separate the columns
 *  above it.
 *
 *  Other seeds first move left and down until the next quad is not free. A region then does not depend on which of
 *  its quads is the seed, and closed meshes, which have no corners, are filled too. */
class RegionFinder {
public:
  RegionFinder(const QuadNeighbors& neighbors, QuadRegions& out) : neighbors(neighbors), out(out) {}

  /*! Assigns all valid quads. For each kind of seeds, first to regions of at least 16 quads per side, then of
   *  minRegionSide; the remaining quads to regions of any size. */
  void run() {
    cbvh::resizeToFit(flags, neighbors.size());
    remainingSteps = stepsPerQuad * neighbors.size();
    for (size_t i = 0; i < neighbors.size(); i++) flags[i] = neighbors.isValid[i] ? 0 : USED;
    out.quads.reserve(neighbors.size());
    for (Seeds seeds : {CORNERS, EDGES, ALL})
      for (unsigned side : {16u, QuadRegions::minRegionSide + 0u}) runPass(seeds, side);
    runPass(CORNERS, 1);
    runPass(ALL, 1);
    auto isRegular = [](const QuadRegions::Region& r) { return min(r.width, r.height) >= QuadRegions::minRegionSide; };
    const auto irregular = std::stable_partition(out.regions.begin(), out.regions.end(), isRegular);
    out.numRegular = size_t(irregular - out.regions.begin());
  }

private:
  enum : unsigned { none = QuadNeighbors::none, maxSide = QuadRegions::maxSide };
  /*! The bits above USED are the last pass in which a region that began here was too small. Unless seeds are
   *  corners, all quads of such a region store it, so that a pass visits each quad once, even in narrow strips. */
  enum Flags : uint8_t { USED = 1, PASS = 2 };
  /*! EDGES: quads without a free quad on the left, or without one below. */
  enum Seeds { CORNERS, EDGES, ALL };

  bool isFree(unsigned quad) const { return quad != none && !(flags[quad] & USED); }
  unsigned at(QuadNeighbors::Side side, unsigned quad) const { return neighbors.at[side][quad]; }

  bool isSeed(unsigned quad, Seeds seeds) const {
    if (!isFree(quad)) return false;
    if (seeds == ALL) return true;
    const bool hasLeft = isFree(at(QuadNeighbors::LEFT, quad)), hasBelow = isFree(at(QuadNeighbors::BELOW, quad));
    return seeds == CORNERS ? !hasLeft && !hasBelow : !hasLeft || !hasBelow;
  }

  /*! A pass: adds the regions of all seeds. side: minimum quads per side. */
  void runPass(Seeds seeds, unsigned side) {
    pass++;
    marksAll = seeds != CORNERS;
    for (size_t i = 0; i < neighbors.size(); i++)
      while (isSeed(unsigned(i), seeds) && !isMarked(unsigned(i)))
        if (!growAll(seeds == CORNERS ? unsigned(i) : moveSeed(unsigned(i)), side, seeds)) break;
  }

  /*! Grows regions from a seed and from seeds that this creates. Returns false if the first is too small. */
  bool growAll(unsigned seed, unsigned side, Seeds seeds) {
    const bool isAdded = grow(seed, side);
    while (!corners.empty() || (seeds == EDGES && !edges.empty())) {
      std::vector<unsigned>& from = corners.empty() ? edges : corners;
      const unsigned quad = from.back();
      from.pop_back();
      if (&from == &corners ? isSeed(quad, CORNERS) : isSeed(quad, EDGES))
        grow(&from == &corners ? quad : moveSeed(quad), side);
    }
    edges.clear();
    return isAdded;
  }

  /*! Moves a seed left, then down, as far as quads are free. Stops after one round in a ring of quads, or
   *  when all seeds together have moved too far. */
  unsigned moveSeed(unsigned quad) {
    for (QuadNeighbors::Side side : {QuadNeighbors::LEFT, QuadNeighbors::BELOW}) {
      const unsigned begin = quad;
      for (unsigned next = at(side, quad); isFree(next) && remainingSteps != 0;
           next = at(side, quad), remainingSteps--) {
        quad = next;
        if (quad == begin) break;
      }
    }
    return quad;
  }

  bool isMarked(unsigned quad) const { return flags[quad] / PASS == pass; }
  unsigned& quadOfRegion(unsigned x, unsigned y) { return region[y * maxSide + x]; }

  /*! Grows a region from a seed and adds it. Returns false, and frees its quads, if it is too small. */
  bool grow(unsigned seed, unsigned side) {
    if (isMarked(seed)) return false;
    quadOfRegion(0, 0) = seed;
    flags[seed] |= USED;
    width = height = 1;
    for (bool canGrowRight = true, canGrowUp = true; canGrowRight || canGrowUp;) {
      if (canGrowRight && (!canGrowUp || width <= height)) canGrowRight = width < maxSide && growRight();
      else canGrowUp = height < maxSide && growUp();
      if ((!canGrowRight && width < side) || (!canGrowUp && height < side)) {
        for (unsigned y = 0; y < height; y++)
          for (unsigned x = 0; x < width; x++)
            if (marksAll) flags[quadOfRegion(x, y)] = uint8_t(pass * PASS);
            else releaseQuad(quadOfRegion(x, y));
        flags[seed] = uint8_t(pass * PASS);
        return false;
      }
    }
    out.regions.push_back(QuadRegions::Region{out.quads.size(), width, height});
    for (unsigned y = 0; y < height; y++)
      for (unsigned x = 0; x < width; x++) out.quads.push_back(quadOfRegion(x, y));
    for (unsigned y = 0; y < height; y++) addSeed(at(QuadNeighbors::RIGHT, quadOfRegion(width - 1, y)));
    for (unsigned x = 0; x < width; x++) addSeed(at(QuadNeighbors::ABOVE, quadOfRegion(x, height - 1)));
    return true;
  }

  /*! Adds a quad that lost a neighbor to the seeds. */
  void addSeed(unsigned quad) {
    if (!isFree(quad)) return;
    if (isSeed(quad, CORNERS)) corners.push_back(quad);
    else edges.push_back(quad);
  }

  void releaseQuad(unsigned quad) { flags[quad] &= uint8_t(~USED); }

  /*! Adds a quad's neighbor to the region if it is free and adjacent to `before`, the quad added before it. */
  bool addNext(unsigned quad, QuadNeighbors::Side side, unsigned before, QuadNeighbors::Side across, unsigned& next) {
    next = at(side, quad);
    if (!isFree(next) || (before != none && at(across, before) != next)) return false;
    flags[next] |= USED;
    return true;
  }

  bool growRight() {
    for (unsigned y = 0, before = none; y < height; before = quadOfRegion(width, y++))
      if (!addNext(quadOfRegion(width - 1, y), QuadNeighbors::RIGHT, before, QuadNeighbors::ABOVE,
                   quadOfRegion(width, y))) {
        while (y-- > 0) releaseQuad(quadOfRegion(width, y));
        return false;
      }
    width++;
    return true;
  }

  bool growUp() {
    for (unsigned x = 0, before = none; x < width; before = quadOfRegion(x++, height))
      if (!addNext(quadOfRegion(x, height - 1), QuadNeighbors::ABOVE, before, QuadNeighbors::RIGHT,
                   quadOfRegion(x, height))) {
        while (x-- > 0) releaseQuad(quadOfRegion(x, height));
        return false;
      }
    height++;
    return true;
  }

  /*! Steps that all seeds together may move, per quad of the mesh: limits the time in long strips. */
  static const size_t stepsPerQuad = 2;

  const QuadNeighbors& neighbors;
  QuadRegions& out;
  cbvh::UnmonitoredVector<uint8_t> flags;
  size_t remainingSteps = 0; //!< steps that seeds may still move
  unsigned pass = 0;
  bool marksAll = false;                //!< also marks quads of regions that are too small
  std::vector<unsigned> corners, edges; //!< seeds that arise while regions are added
  unsigned region[maxSide * maxSide];   //!< quads of the growing region
  unsigned width = 0, height = 0;
};

/*! Pairs triangles that follow each other in the index buffer. firsts: set to the first triangles of pairs; empty
 *  if these are all triangles 2i. Returns false if less than half of a sample of triangles shares an edge with the
 *  next or previous one. */
bool findConsecutivePairs(const TriangleMesh* mesh, const WeldedVertices* welded, mvector<unsigned>& firsts) {
  const size_t n = mesh->triangles.size();
  const PairsOfMesh triangles = {mesh, welded, nullptr, nullptr};
  auto isPair = [&](size_t i) { return i + 1 < n && triangles.shareEdge(i, i + 1); };
  const size_t step = max(n / 4096, size_t(1));
  size_t numSampled = 0, paired = 0;
  for (size_t i = 0; i < n; i += step, numSampled++) paired += isPair(i) || (i > 0 && isPair(i - 1));
  if (2 * paired < numSampled) return false;
  const size_t perTask = 1 << 14;
  auto arePairs = [&](const range<size_t>& r) {
    for (size_t i = r.begin(); i != r.end(); i++)
      if (!isPair(2 * i)) return false;
    return true;
  };
  if (n % 2 == 0 && parallel_reduce(size_t(0), n / 2, perTask, true, arePairs, std::logical_and<bool>())) return true;
  for (size_t i = 0; i < n; i += isPair(i) ? 2 : 1) firsts.push_back(unsigned(i));
  return true;
}

typedef std::shared_ptr<QuadRegions> RegionsPtr;

/*! Finds the regions for the welded vertices and pairs in `out`. */
template<typename Mesh>
void findRegions(const Mesh* mesh, QuadRegions& out) {
  const auto quads = quadsOf(mesh, out);
  if (quads.size() == 0) return;
  QuadNeighbors neighbors;
  if (!NeighborFinder<decltype(quadsOf(mesh, out))>(quads, mesh->numVertices(), neighbors).run()) return;
  out.firstCornersDiffer = neighbors.firstCornersDiffer;
  out.numInvalid = neighbors.numInvalid;
  RegionFinder(neighbors, out).run();
}

/*! Finds regions of a quad mesh, or of a triangle mesh with pairs of consecutive triangles. */
RegionsPtr findWithConsecutivePairs(const QuadMesh* mesh, const std::shared_ptr<const WeldedVertices>& welded) {
  const RegionsPtr out = std::make_shared<QuadRegions>();
  out->welded = welded;
  findRegions(mesh, *out);
  return out;
}

RegionsPtr findWithConsecutivePairs(const TriangleMesh* mesh, const std::shared_ptr<const WeldedVertices>& welded) {
  const RegionsPtr out = std::make_shared<QuadRegions>();
  out->welded = welded;
  if (findConsecutivePairs(mesh, welded.get(), out->firsts)) findRegions(mesh, *out);
  return out;
}

/*! Finds regions of a triangle mesh with pairs from anywhere in the index buffer, if they can contain more triangles
 *  than the regular ones of `before`. Null for quad meshes. */
RegionsPtr findWithAnyPairs(const TriangleMesh* mesh, const std::shared_ptr<const WeldedVertices>& welded,
                            const QuadRegions& before) {
  const RegionsPtr out = std::make_shared<QuadRegions>();
  out->welded = welded;
  const size_t inGrids = 2 * before.numQuads(0, before.numRegular);
  if (pairTriangles(mesh, welded.get(), inGrids, out->firsts, out->seconds)) findRegions(mesh, *out);
  return out;
}

RegionsPtr findWithAnyPairs(const QuadMesh*, const std::shared_ptr<const WeldedVertices>&, const QuadRegions&) {
  return nullptr;
}

/*! True if at most 5% of the quads are irregular. */
bool areFewIrregular(const QuadRegions& found) {
  const size_t ratio = 20;
  const size_t all = found.numQuads(0, found.regions.size());
  return all != 0 && ratio * found.numQuads(found.numRegular, found.regions.size()) <= all;
}

/*! Estimates the tables of numbers of all blocks from a sample of regions. */
template<typename Mesh>
size_t estimateTables(const Mesh* mesh, const QuadRegions& found) {
  const size_t step = found.regions.size() / 64 + 1;
  size_t bytes = 0, numSampled = 0;
  cbvh::QuadNumbers numbers;
  cbvh::NumbersEncoder encoder;
  for (size_t i = 0; i < found.regions.size(); i += step) {
    const QuadRegions::Region& r = found.regions[i];
    bytes += bytesOfTables(quadsOf(mesh, found), found, i, numbers, encoder);
    numSampled += size_t(r.width) * r.height;
  }
  return size_t(double(bytes) * double(found.numQuads(0, found.regions.size())) / double(max(numSampled, size_t(1))));
}

/*! Sets best to other if that needs fewer bytes. other: may be null. */
template<typename Mesh>
void chooseSmaller(const Mesh* mesh, RegionsPtr& best, const RegionsPtr& other) {
  if (!other || other->regions.empty()) return;
  auto bytes = [&](const RegionsPtr& found) {
    const size_t blocks = mesh->numTimeSteps == 1 ? found->bytesWithMeshBlocks() : found->bytesOfBlocks();
    return blocks + estimateTables(mesh, *found);
  };
  if (best->regions.empty() || bytes(other) < bytes(best)) best = other;
}

/*! True if nearly all blocks are full, so that other regions could save at most 10%. */
bool areBlocksNearlyFull(const QuadRegions& found) {
  const size_t quads = found.numQuads(0, found.regions.size()), side = cbvh::vertBlockQuads;
  const double least = double(bytesOfGridBlocks(side, side, true)) * double(quads) / double(side * side);
  return quads != 0 && double(found.bytesOfBlocks()) <= 1.1 * least;
}

/*! If pairs of consecutive triangles leave many quads irregular, also tries partners anywhere. */
template<typename Mesh>
RegionsPtr findWithBestPairs(const Mesh* mesh, const std::shared_ptr<const WeldedVertices>& welded) {
  RegionsPtr best = findWithConsecutivePairs(mesh, welded);
  if (!areFewIrregular(*best)) chooseSmaller(mesh, best, findWithAnyPairs(mesh, welded, *best));
  return best;
}

bool mayHaveLargeGrids(const QuadMesh*) { return true; }

size_t numQuadsOf(const QuadMesh* mesh) { return mesh->quads.size(); }
size_t numQuadsOf(const TriangleMesh* mesh) { return mesh->triangles.size() / 2; }

/*! Finds regions by vertex indices and by welded vertices, and returns the smaller result. Tries indices first,
 *  unless there are so many vertices that each quad may have its own. Welding can need more bytes, if an
 *  application numbered quads region by region, without sharing vertices between regions. */
template<typename Mesh>
std::shared_ptr<const QuadRegions> findBest(const Mesh* mesh) {
  if (!mayHaveLargeGrids(mesh)) return std::make_shared<QuadRegions>();
  const bool areVerticesSeparate = mesh->numVertices() > 2 * numQuadsOf(mesh);
  RegionsPtr best;
  if (!areVerticesSeparate) {
    best = findWithConsecutivePairs(mesh, nullptr);
    if (areBlocksNearlyFull(*best)) return best;
  }
  const std::shared_ptr<const WeldedVertices> welded =
      WeldedVertices::find(&mesh->vertices[0], mesh->numTimeSteps, mesh->numVertices());
  if (welded || !best) {
    const RegionsPtr other = findWithBestPairs(mesh, welded);
    if (best) chooseSmaller(mesh, best, other);
    else best = other;
  } else if (!areFewIrregular(*best)) chooseSmaller(mesh, best, findWithAnyPairs(mesh, nullptr, *best));
  if (welded && areVerticesSeparate && !areBlocksNearlyFull(*best))
    chooseSmaller(mesh, best, findWithConsecutivePairs(mesh, nullptr));
  return best;
}
} // namespace

static size_t bytesAsGrid(const QuadRegions::Region& region) {
  return bytesOfGridBlocks(region.width, region.height, true);
}

static size_t bytesAsMeshBlocks(const QuadRegions::Region& region) {
  return bytesOfMeshTriangles(2 * size_t(region.width) * region.height);
}

size_t QuadRegions::bytesOfBlocks() const {
  size_t bytes = 0;
  for (const Region& region : regions) bytes += bytesAsGrid(region);
  return bytes;
}

size_t QuadRegions::bytesWithMeshBlocks() const {
  size_t bytes = 0;
  for (const Region& region : regions)
    bytes += isSmallerInMeshBlocks(region) ? bytesAsMeshBlocks(region) : bytesAsGrid(region);
  return bytes;
}

bool QuadRegions::isSmallerInMeshBlocks(const Region& region, size_t tables) {
  return bytesAsMeshBlocks(region) <= bytesOfMeshGrid(region.width, region.height, tables);
}

bool QuadRegions::dependsOnTables(const Region& region) {
  return isSmallerInMeshBlocks(region, maxTableBytes * region.width * region.height) && !isSmallerInMeshBlocks(region);
}

size_t QuadRegions::numQuads(size_t beginRegion, size_t endRegion) const {
  size_t n = 0;
  for (size_t i = beginRegion; i < endRegion; i++) n += size_t(regions[i].width) * regions[i].height;
  return n;
}

std::shared_ptr<const QuadRegions> QuadRegions::find(const QuadMesh* mesh) { return findBest(mesh); }
std::shared_ptr<const QuadRegions> QuadRegions::find(const TriangleMesh* mesh) { return findBest(mesh); }
} // namespace embree
