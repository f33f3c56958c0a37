// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Half-edge 3 t + e is edge e of triangle t, from corner e to the next corner. */

#include "triangle_pairs.h"
#include "../base/atomic_ref.h"
#include "../base/resize_to_fit.h"
#include "quad_regions.h"
#include <algorithm>
#include <vector>

namespace embree {
namespace {
class PairFinder {
public:
  PairFinder(const TriangleMesh* mesh, const WeldedVertices* welded)
    : mesh(mesh),
      welded(welded),
      size(mesh->triangles.size()),
      numVertices(mesh->numVertices()) {}

  void run(mvector<unsigned>& firsts, mvector<unsigned>& seconds) {
    copyTriangles();
    findEdges();
    fill(partners, size, unsigned(none));
    const Edges edges = chooseEdges();
    if (!edges.isNone() && edges.first != edges.second) pairBy(edges);
    spreadPairs(edges);
    size_t numPairs = 0;
    for (size_t t = 0; t < size; t++) numPairs += partners[t] != second;
    cbvh::resizeToFit(firsts, numPairs);
    cbvh::resizeToFit(seconds, numPairs);
    for (size_t t = 0, i = 0; t < size; t++)
      if (partners[t] != second) {
        firsts[i] = triangles[t].number;
        seconds[i++] = triangles[partners[t] == none ? t : partners[t]].number;
      }
  }

private:
  enum : unsigned { none = ~0u, second = ~1u }; //!< see `partners`
  static const size_t perTask = size_t(1) << 14;
  static const size_t samples = 4096;

  struct Triangle {
    unsigned v[3]; //!< welded vertices
    unsigned number;
  };

  /*! Half-edge in the list of its lower vertex. */
  struct SortedHalfEdge {
    unsigned key; //!< twice the higher vertex, plus 1 if the half-edge begins there
    unsigned half;
    bool operator<(const SortedHalfEdge& other) const { return key < other.key; }
  };

  /*! Edges (0 to 2) at which first triangles, and second triangles, of all pairs are joined. */
  struct Edges {
    unsigned first, second;
    bool isNone() const { return first == none; }
  };

  static unsigned next(unsigned half) { return half % 3 == 2 ? half - 2 : half + 1; }
  static unsigned previous(unsigned half) { return half % 3 == 0 ? half + 2 : half - 1; }

  static void fill(mvector<unsigned>& table, size_t size, unsigned value) {
    cbvh::resizeToFit(table, size);
    parallel_for(size_t(0), size, 4 * perTask,
                 [&](const range<size_t>& r) { std::fill(table.begin() + r.begin(), table.begin() + r.end(), value); });
  }

  Triangle triangle(size_t number) const {
    Triangle t;
    memcpy(t.v, mesh->triangles.getPtr(number), sizeof(t.v));
    if (welded)
      for (unsigned& v : t.v) v = (*welded)[v];
    t.number = unsigned(number);
    return t;
  }

  bool isValid(const Triangle& t) const { return max(max(t.v[0], t.v[1]), t.v[2]) < numVertices; }

  /*! The triangle's lowest vertex, for sorting; numVertices if the triangle is invalid. */
  unsigned vertexOf(const Triangle& t) const {
    return isValid(t) ? min(min(t.v[0], t.v[1]), t.v[2]) : unsigned(numVertices);
  }

  /*! True if vertices of consecutive triangles tend to be far apart in the buffer. */
  bool areScattered() const {
    const size_t step = max(size / samples, size_t(2));
    size_t numSampled = 0, numFar = 0;
    for (size_t t = 0; t + 1 < size; t += step, numSampled++) {
      const unsigned a = vertexOf(triangle(t)), b = vertexOf(triangle(t + 1));
      numFar += size_t(max(a, b) - min(a, b)) > numVertices / 64;
    }
    return 2 * numFar > numSampled;
  }

  /*! Copies the triangles, because later phases read them in the order of neighbors. Sorts scattered triangles by
   *  lowest vertex, because consecutive vertices are often near each other. */
  void copyTriangles() {
    cbvh::resizeToFit(triangles, size);
    if (!areScattered()) {
      parallel_for(size_t(0), size, perTask, [&](const range<size_t>& r) {
        for (size_t t = r.begin(); t != r.end(); t++) triangles[t] = triangle(t);
      });
      return;
    }
    fill(ends, numVertices + 2, 0u);
    parallel_for(size_t(0), size, perTask, [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++) increment(ends[vertexOf(triangle(t))]);
    });
    prefixSums(ends);
    parallel_for(size_t(0), size, perTask, [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++) {
        const Triangle t = triangle(i);
        triangles[decrement(ends[vertexOf(t)])] = t;
      }
    });
    parallel_for(size_t(0), numVertices + 1, perTask, [&](const range<size_t>& r) {
      for (size_t v = r.begin(); v != r.end(); v++)
        std::sort(triangles.begin() + ends[v], triangles.begin() + ends[v + 1],
                  [](const Triangle& a, const Triangle& b) { return a.number < b.number; });
    });
    ends.clear();
  }

  static void increment(unsigned& count) { cbvh::AtomicRef<unsigned>(count).fetchAdd(1u, std::memory_order_relaxed); }

  static unsigned decrement(unsigned& count) {
    return cbvh::AtomicRef<unsigned>(count).fetchAdd(~0u, std::memory_order_relaxed) - 1;
  }

  static void prefixSums(mvector<unsigned>& counts) {
    unsigned sum = 0;
    for (unsigned& count : counts) count = sum += count;
  }

  /*! Calls closure(lower vertex, SortedHalfEdge) for edges whose vertices differ. */
  template<typename Closure>
  void forEachHalf(size_t triangle, const Closure& closure) const {
    const Triangle& t = triangles[triangle];
    if (!isValid(t)) return;
    for (unsigned e = 0; e < 3; e++) {
      const unsigned a = t.v[e], b = t.v[e == 2 ? 0 : e + 1];
      if (a != b) closure(min(a, b), SortedHalfEdge{2 * max(a, b) + (a > b), unsigned(3 * triangle) + e});
    }
  }

  /*! Sets `opposite`: sorts half-edges by their lower vertex (counting sort), and joins those of each vertex. */
  void findEdges() {
    fill(ends, numVertices + 1, 0u);
    parallel_for(size_t(0), size, perTask, [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++)
        forEachHalf(t, [&](unsigned v, const SortedHalfEdge&) { increment(ends[v]); });
    });
    prefixSums(ends);
    cbvh::resizeToFit(halves, ends[numVertices]);
    parallel_for(size_t(0), size, perTask, [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++)
        forEachHalf(t, [&](unsigned v, const SortedHalfEdge& half) { halves[decrement(ends[v])] = half; });
    });
    fill(opposite, 3 * size, unsigned(none));
    parallel_for(size_t(0), numVertices, perTask, [&](const range<size_t>& r) {
      for (size_t v = r.begin(); v != r.end(); v++) join(halves.data() + ends[v], halves.data() + ends[v + 1]);
    });
  }

  /*! Finds the opposites among the half-edges of a vertex: of edges with exactly two half-edges, of different
   *  directions. */
  void join(SortedHalfEdge* begin, SortedHalfEdge* end) {
    if (end - begin > 16) std::sort(begin, end);
    else // insertion sort: most vertices have six
      for (SortedHalfEdge* i = begin; i < end; i++)
        for (SortedHalfEdge* j = i; j != begin && *j < j[-1]; j--) std::swap(*j, j[-1]);
    for (SortedHalfEdge *i = begin, *j; i != end; i = j) {
      for (j = i + 1; j != end && j->key / 2 == i->key / 2; j++) {}
      if (j != i + 2 || i[0].key == i[1].key) continue;
      opposite[i[0].half] = i[1].half;
      opposite[i[1].half] = i[0].half;
    }
  }

  /*! Squared length of a half-edge at the first time step; 0 if it is not finite. */
  double squaredLength(unsigned half) const {
    const unsigned* const v = triangles[half / 3].v;
    const float* const p = (const float*)mesh->vertices[0].getPtr(v[half % 3]);
    const float* const q = (const float*)mesh->vertices[0].getPtr(v[next(half) % 3]);
    double square = 0;
    for (int k = 0; k < 3; k++) square += (double(p[k]) - q[k]) * (double(p[k]) - q[k]);
    return square < std::numeric_limits<double>::infinity() ? square : 0;
  }

  /*! True if edge e of a triangle is the opposite of edge f of another. */
  bool isJoined(unsigned triangle, unsigned e, unsigned f) const {
    const unsigned other = opposite[3 * triangle + e];
    return other != none && other % 3 == f;
  }

  /*! Returns the half-edge at which a triangle is paired if pairs share `edges`, or none. If both edges qualify,
   *  returns the longer one, as the diagonal of a quad. */
  unsigned sharedHalf(unsigned triangle, const Edges& edges) const {
    const unsigned first = 3 * triangle + edges.first, second = 3 * triangle + edges.second;
    const bool isFirst = isJoined(triangle, edges.first, edges.second);
    if (edges.first == edges.second) return isFirst ? first : unsigned(none);
    const bool isSecond = isJoined(triangle, edges.second, edges.first);
    if (isFirst && isSecond) return squaredLength(first) > squaredLength(second) ? first : second;
    return isFirst ? first : isSecond ? second : unsigned(none);
  }

  /*! Returns the triangle with which a triangle is paired, or none. isFirst: set to true if `triangle` is the
   *  pair's first one. */
  unsigned partnerOf(unsigned triangle, const Edges& edges, bool& isFirst) const {
    const unsigned half = sharedHalf(triangle, edges);
    if (half == none) return none;
    const unsigned other = opposite[half], partner = other / 3;
    if (sharedHalf(partner, edges) != other) return none;
    isFirst =
        edges.first == edges.second ? triangles[triangle].number < triangles[partner].number : half % 3 == edges.first;
    return partner;
  }

  /*! Statistics of the pairs that two edges create, from a sample. */
  struct Pairing {
    Edges edges;
    size_t paired = 0, lower = 0; //!< triangles in pairs; of these, in pairs whose first one has the lower number
    double squaredLengths = 0;    //!< sum over the sample
  };

  /*! numSampled: size of the sample. */
  Pairing samplePairs(const Edges& edges, size_t& numSampled) const {
    Pairing pairing;
    pairing.edges = edges;
    numSampled = 0;
    const size_t step = max(size / samples, size_t(1));
    for (size_t i = 0; i < size; i += step, numSampled++) {
      const unsigned t = unsigned(i);
      bool isFirst;
      const unsigned partner = partnerOf(t, edges, isFirst);
      if (partner == none) continue;
      pairing.paired++;
      pairing.lower += isFirst == (triangles[t].number < triangles[partner].number);
      const unsigned edge = edges.first == edges.second || isFirst ? edges.first : edges.second;
      pairing.squaredLengths += squaredLength(3 * t + edge);
    }
    return pairing;
  }

  /*! Returns the edges that pair the most triangles of a sample, the longest of several; none if they pair less
   *  than three quarters. */
  Edges chooseEdges() const {
    std::vector<Pairing> all;
    size_t most = 0, numSampled = 0;
    for (unsigned e = 0; e < 3; e++)
      for (unsigned f = e; f < 3; f++) {
        all.push_back(samplePairs(Edges{e, f}, numSampled));
        most = max(most, all.back().paired);
      }
    if (4 * most < 3 * numSampled) return Edges{none, none};
    const Pairing* best = nullptr;
    for (const Pairing& pairing : all) // pairs at borders may be missing
      if (pairing.paired + most / 256 >= most && (!best || pairing.squaredLengths > best->squaredLengths))
        best = &pairing;
    const bool isFirst = 2 * best->lower >= best->paired;
    return isFirst ? best->edges : Edges{best->edges.second, best->edges.first};
  }

  void pairBy(const Edges& edges) {
    parallel_for(size_t(0), size, perTask, [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++) {
        bool isFirst;
        const unsigned partner = partnerOf(unsigned(t), edges, isFirst);
        if (partner != none) partners[t] = isFirst ? partner : unsigned(second);
      }
    });
  }

  /*! Pairs the remaining triangles along rows and columns of quads, starting with a first pair. Only across
   *  `edges`, unless they are none. */
  void spreadPairs(const Edges& edges) {
    auto isFree = [&](unsigned half) {
      if (half == none || opposite[half] == none) return false;
      const unsigned other = opposite[half];
      if (!edges.isNone() && (half % 3 != edges.first || other % 3 != edges.second) &&
          (half % 3 != edges.second || other % 3 != edges.first))
        return false;
      return partners[half / 3] == none && partners[other / 3] == none && half / 3 != other / 3;
    };
    std::vector<unsigned> found; // shared half-edges of first triangles
    auto addPair = [&](unsigned half) {
      partners[half / 3] = opposite[half] / 3;
      partners[opposite[half] / 3] = second;
      found.push_back(half);
    };
    for (size_t t = 0, done = 0; t < size; t++, done = 0) {
      if (partners[t] != none) continue;
      unsigned longest = none;
      for (unsigned half = unsigned(3 * t); half < unsigned(3 * t) + 3; half++)
        if (isFree(half) && (longest == none || squaredLength(half) > squaredLength(longest))) longest = half;
      if (longest == none) continue;
      addPair(longest);
      for (; done < found.size(); done++) {
        /* Corners are 00, 10, 01 and 11, 01, 10. `half` leads from 10 to 01 in the first triangle. */
        const unsigned half = found[done], back = opposite[half];
        const unsigned right = opposite[next(back)], up = opposite[previous(back)];
        const unsigned left = opposite[next(half)], down = opposite[previous(half)];
        if (right != none && isFree(previous(right))) addPair(previous(right));
        if (up != none && isFree(next(up))) addPair(next(up));
        if (left != none && isFree(previous(left))) addPair(opposite[previous(left)]);
        if (down != none && isFree(next(down))) addPair(opposite[next(down)]);
      }
      found.clear();
    }
  }

  const TriangleMesh* const mesh;
  const WeldedVertices* const welded;
  const size_t size, numVertices;
  cbvh::UnmonitoredVector<Triangle> triangles;    //!< half-edges and partners are indices into it
  cbvh::UnmonitoredVector<unsigned> ends;         //!< counting sort: end, later begin, of each vertex's range
  cbvh::UnmonitoredVector<SortedHalfEdge> halves; //!< by lower vertex
  cbvh::UnmonitoredVector<unsigned> opposite;     //!< opposite half-edge, or `none`
  cbvh::UnmonitoredVector<unsigned> partners;     //!< a first triangle's second one; otherwise `second` or `none`
};

/*! Decides whether the search for grids is worthwhile, by the number of triangles per vertex: six in a regular
 *  mesh. */
class RegularityTest {
public:
  RegularityTest(const TriangleMesh* mesh, const WeldedVertices* welded)
    : triangles{mesh, welded, nullptr, nullptr},
      size(mesh->triangles.size()),
      numVertices(mesh->numVertices()) {}

  /*! True if at least half of the sampled vertices have six triangles. With random diagonals, 3 in 8 do. In less
   *  regular meshes, most quads would be irregular. */
  bool areVerticesRegular() {
    count(IsSampled{numVertices < 4096, 26}); // one vertex in 64
    const size_t unused = size_t(std::count(counts.begin(), counts.end(), 0));
    return 2 * size_t(std::count(counts.begin(), counts.end(), 6)) >= counts.size() - unused;
  }

  /*! True if at least an eighth of a sample of vertices are deep inside of a regular part: they, all adjacent
   *  vertices and all vertices adjacent to these have six triangles. This is so in patches of 10 x 10 quads around
   *  grids of 8 x 8. In patches of up to 8 x 8, grids would save 5% of the bytes, and double the time of a commit. */
  bool hasLargeGrids() {
    enum : uint8_t { WITHIN_2 = 1, WITHIN_1 = 2, NEAR_IRREGULAR = 4, NOT_DEEP = 8 }; // edges to a sampled vertex
    const IsSampled isSampled = {numVertices < 4096, 23};                            // one vertex in 512
    count(isSampled); // first the vertices alone, because regular meshes need no further passes
    const size_t unused = size_t(std::count(counts.begin(), counts.end(), 0));
    if (16 * size_t(std::count(counts.begin(), counts.end(), 6)) >= 15 * (counts.size() - unused)) return true;
    cbvh::UnmonitoredVector<uint8_t> marks;
    clear(marks);
    auto isMarked = [&](unsigned v, uint8_t bit) {
      return (cbvh::AtomicRef<uint8_t>(marks[v]).load(std::memory_order_relaxed) & bit) != 0;
    };
    auto mark = [&](unsigned v, uint8_t bit) {
      cbvh::AtomicRef<uint8_t>(marks[v]).fetchOr(bit, std::memory_order_relaxed);
    };
    auto isAnySampled = [&](const unsigned v[3]) { return isSampled(v[0]) || isSampled(v[1]) || isSampled(v[2]); };
    auto isAnyMarked = [&](const unsigned v[3], uint8_t bit) {
      return isMarked(v[0], bit) || isMarked(v[1], bit) || isMarked(v[2], bit);
    };
    forEachTriangle([&](const unsigned v[3]) {
      if (!isAnySampled(v) || !areValid(v)) return;
      for (int c = 0; c < 3; c++) mark(v[c], WITHIN_1);
    });
    forEachTriangle([&](const unsigned v[3]) {
      if (!areValid(v) || !isAnyMarked(v, WITHIN_1)) return;
      for (int c = 0; c < 3; c++) mark(v[c], WITHIN_2);
    });
    count([&](unsigned v) { return v < numVertices && isMarked(v, WITHIN_2); });
    forEachTriangle([&](const unsigned v[3]) {
      if (!areValid(v) || !isAnyMarked(v, WITHIN_1)) return;
      if (countOf(v[0]) == 6 && countOf(v[1]) == 6 && countOf(v[2]) == 6) return;
      for (int c = 0; c < 3; c++)
        if (isMarked(v[c], WITHIN_1)) mark(v[c], NEAR_IRREGULAR);
    });
    forEachTriangle([&](const unsigned v[3]) {
      if (!isAnySampled(v) || !areValid(v) || !isAnyMarked(v, NEAR_IRREGULAR)) return;
      for (int c = 0; c < 3; c++)
        if (isSampled(v[c])) mark(v[c], NOT_DEEP);
    });
    size_t numUsed = 0, numDeep = 0;
    for (size_t v = 0; v < numVertices; v++)
      if (isSampled(unsigned(v)) && counts[v] != 0) {
        numUsed++;
        numDeep += (marks[v] & NOT_DEEP) == 0;
      }
    return 8 * numDeep >= numUsed;
  }

  /*! True if at least a quarter of the triangles, and more than inGrids, are inside of a regular part: all their
   *  vertices, and all adjacent ones, have six triangles. In CAD models, where cylinders and fillets are narrow strips,
   *  the search would take as long as the rest of the build, and its regions hardly reduce memory but slow rays. In
   *  adaptively subdivided surfaces, where strips of triangles stitch the grids of patches, it would only find the
   *  grids that the order of the triangles already reveals. */
  bool hasWideParts(size_t inGrids) {
    count([](unsigned) { return true; });
    const uint8_t nearIrregular = 128; // bit of a vertex with six triangles if an adjacent one differs
    forEachTriangle([&](const unsigned v[3]) {
      if (!areValid(v)) return;
      auto isSix = [&](int c) { return (countOf(v[c]) | nearIrregular) == (6 | nearIrregular); };
      if (isSix(0) && isSix(1) && isSix(2)) return;
      for (int c = 0; c < 3; c++)
        if (isSix(c)) cbvh::AtomicRef<uint8_t>(counts[v[c]]).fetchOr(nearIrregular, std::memory_order_relaxed);
    });
    const size_t numInside = parallel_reduce(
        size_t(0), size, size_t(perTask), size_t(0),
        [&](const range<size_t>& r) {
          size_t n = 0;
          for (size_t t = r.begin(); t != r.end(); t++) {
            unsigned v[3];
            triangles.triangle(t, v);
            n += areValid(v) && countOf(v[0]) == 6 && countOf(v[1]) == 6 && countOf(v[2]) == 6;
          }
          return n;
        },
        std::plus<size_t>());
    return 4 * numInside >= size && numInside > inGrids;
  }

private:
  static const size_t perTask = size_t(1) << 14;

  /*! function(v): v are the vertices of a triangle. Called concurrently. */
  template<typename Function>
  void forEachTriangle(const Function& function) const {
    parallel_for(size_t(0), size, size_t(perTask), [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++) {
        unsigned v[3];
        triangles.triangle(t, v);
        function(v);
      }
    });
  }

  /*! Chooses one vertex in 2^(32-shift), or all if there are few. */
  struct IsSampled {
    const bool isSmall;
    const unsigned shift;
    bool operator()(unsigned vertex) const { return isSmall || (vertex * 0x9E3779B1u) >> shift == 0; }
  };

  bool areValid(const unsigned v[3]) const { return max(max(v[0], v[1]), v[2]) < numVertices; }

  unsigned countOf(unsigned vertex) { return cbvh::AtomicRef<uint8_t>(counts[vertex]).load(std::memory_order_relaxed); }

  void clear(cbvh::UnmonitoredVector<uint8_t>& table) const {
    cbvh::resizeToFit(table, numVertices);
    std::fill(table.begin(), table.end(), uint8_t(0));
  }

  /*! Sets `counts` of the vertices that are sampled. */
  template<typename IsSampled>
  void count(const IsSampled& isSampled) {
    clear(counts);
    forEachTriangle([&](const unsigned v[3]) {
      for (int c = 0; c < 3; c++)
        if (isSampled(v[c]) && v[c] < numVertices)
          cbvh::AtomicRef<uint8_t>(counts[v[c]]).fetchAdd(1, std::memory_order_relaxed);
    });
  }

  const PairsOfMesh triangles;
  const size_t size, numVertices;
  cbvh::UnmonitoredVector<uint8_t> counts; //!< triangles per vertex, modulo 256
};

/*! True if almost all sampled triangles of the mesh's first half share an edge with the corresponding one of the
 *  second. */
bool areHalves(const TriangleMesh* mesh, const WeldedVertices* welded) {
  const size_t n = mesh->triangles.size() / 2, step = max(n / 4096, size_t(1));
  const PairsOfMesh triangles = {mesh, welded, nullptr, nullptr};
  if (mesh->triangles.size() != 2 * n) return false;
  size_t numSampled = 0, joined = 0;
  for (size_t t = 0; t < n; t += step, numSampled++) joined += triangles.shareEdge(t, n + t);
  return 16 * joined >= 15 * numSampled;
}

/*! Pairs corresponding triangles of both halves that share an edge. */
void pairHalves(const TriangleMesh* mesh, const WeldedVertices* welded, mvector<unsigned>& firsts,
                mvector<unsigned>& seconds) {
  const size_t n = mesh->triangles.size() / 2;
  const PairsOfMesh triangles = {mesh, welded, nullptr, nullptr};
  cbvh::resizeToFit(firsts, n);
  cbvh::resizeToFit(seconds, n);
  const size_t numJoined = parallel_reduce(
      size_t(0), n, size_t(1) << 14, size_t(0),
      [&](const range<size_t>& r) {
        size_t numJoined = 0;
        for (size_t t = r.begin(); t != r.end(); t++) {
          const bool isJoined = triangles.shareEdge(t, n + t);
          firsts[t] = unsigned(t);
          seconds[t] = unsigned(isJoined ? n + t : t);
          numJoined += isJoined;
        }
        return numJoined;
      },
      std::plus<size_t>());
  if (numJoined == n) return;
  for (size_t t = 0; t < n; t++)
    if (seconds[t] == t) {
      firsts.push_back(unsigned(n + t));
      seconds.push_back(unsigned(n + t));
    }
}
} // namespace

bool mayHaveLargeGrids(const TriangleMesh* mesh) {
  // a welded mesh has one vertex per two triangles; if there are more, welding could create regular parts
  const size_t quads = mesh->triangles.size() / 2;
  return mesh->numVertices() > quads + quads / 16 || RegularityTest(mesh, nullptr).hasLargeGrids();
}

bool pairTriangles(const TriangleMesh* mesh, const WeldedVertices* welded, size_t inGrids, mvector<unsigned>& firsts,
                   mvector<unsigned>& seconds) {
  RegularityTest test(mesh, welded);
  if (!test.areVerticesRegular()) return false;
  if (areHalves(mesh, welded)) {
    pairHalves(mesh, welded, firsts, seconds);
    return true;
  }
  if (!test.hasWideParts(inGrids)) return false;
  if (mesh->triangles.size() >= size_t(1) << 30 || mesh->numVertices() >= size_t(1) << 31) return false;
  PairFinder(mesh, welded).run(firsts, seconds);
  return true;
}
} // namespace embree
