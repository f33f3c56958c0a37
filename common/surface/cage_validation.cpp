// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/cage_validation.h"
#include "basics/error.h"
#include "surface/crease_rules.h"
#include "surface/topology_refiner.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace programs {
namespace {

namespace Far = OpenSubdiv::Far;

/* MAX_PATCH_VALENCE and MAX_RING_FACE_VALENCE in Embree's kernels/subdiv, as patched. */
constexpr unsigned maxFaceVertices = 16;
constexpr int maxVertexFaces = 1024;

/* Thread-local, because OpenSubdiv reports through a plain function. */
thread_local std::string lastReport;

void recordError(Far::ErrorType, const char* message) {
  if (lastReport.empty()) lastReport = message;
}

void recordWarning(const char* message) {
  if (lastReport.empty()) lastReport = message;
}

std::string oneLine(std::string text) {
  for (char& c : text)
    if (c == '\n') c = ' ';
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::string faces(size_t n) { return std::to_string(n) + (n == 1 ? " face" : " faces"); }

/* These messages name the face, unlike OpenSubdiv's. */
void checkFaces(const Cage& cage) {
  size_t offset = 0;
  for (size_t face = 0; face < cage.numFaces(); offset += cage.faceSizes[face++]) {
    const unsigned size = cage.faceSizes[face];
    std::vector<unsigned> vertices(cage.faceIndices.begin() + ptrdiff_t(offset),
                                   cage.faceIndices.begin() + ptrdiff_t(offset + size));
    std::sort(vertices.begin(), vertices.end());
    const auto twice = std::adjacent_find(vertices.begin(), vertices.end());
    if (twice != vertices.end())
      throw Error(cage.name + ": face " + std::to_string(face + 1) + " contains vertex " + std::to_string(*twice + 1) +
                  " twice; expected different vertices");
  }
}

std::string counted(size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

using Edge = std::pair<unsigned, unsigned>;

Edge ordered(Edge edge) { return {std::min(edge.first, edge.second), std::max(edge.first, edge.second)}; }

/* Creases between vertices that share no edge, which Embree ignores. */
void removeCreasesWithoutEdge(Cage& cage, std::string& warnings) {
  if (cage.creaseEdges.empty()) return;
  std::set<Edge> edges;
  size_t first = 0;
  for (unsigned size : cage.faceSizes) {
    for (unsigned i = 0; i < size; i++)
      edges.insert(ordered({cage.faceIndices[first + i], cage.faceIndices[first + (i + 1) % size]}));
    first += size;
  }
  std::vector<Edge> removed;
  size_t kept = 0;
  for (size_t i = 0; i < cage.creaseEdges.size(); i++) {
    if (edges.count(ordered(cage.creaseEdges[i]))) {
      cage.creaseEdges[kept] = cage.creaseEdges[i];
      cage.creaseSharpness[kept++] = cage.creaseSharpness[i];
    } else removed.push_back(cage.creaseEdges[i]);
  }
  cage.creaseEdges.resize(kept);
  cage.creaseSharpness.resize(kept);
  if (!removed.empty())
    warnings += cage.name + ": a crease joins the vertices " + std::to_string(removed[0].first + 1) + " and " +
                std::to_string(removed[0].second + 1) + ", which share no edge, and is ignored" +
                (removed.size() == 1 ? "" : ", like " + counted(removed.size() - 1, "other", "others")) + "\n";
}

std::unique_ptr<Far::TopologyRefiner> makeRefiner(const Cage& cage) {
  lastReport.clear();
  Far::SetErrorCallback(recordError);
  Far::SetWarningCallback(recordWarning);
  std::unique_ptr<Far::TopologyRefiner> refiner = makeTopologyRefiner(cage, true);
  Far::SetErrorCallback(nullptr);
  Far::SetWarningCallback(nullptr);
  if (!refiner || !lastReport.empty())
    throw Error(cage.name + ": OpenSubdiv: " + oneLine(lastReport.empty() ? "invalid topology" : lastReport));
  return refiner;
}

void warnOfEdges(const Cage& cage, const Far::TopologyLevel& level, std::string& warnings) {
  std::vector<int> edges;
  for (int edge = 0; edge < level.GetNumEdges(); edge++)
    if (level.IsEdgeNonManifold(edge)) edges.push_back(edge);
  if (edges.empty()) return;
  const Far::ConstIndexArray v = level.GetEdgeVertices(edges.front());
  warnings += cage.name + ": not manifold at " + counted(edges.size(), "edge", "edges") + ": the edge from vertex " +
              std::to_string(v[0] + 1) + " to " + std::to_string(v[1] + 1) + " has " +
              faces(size_t(level.GetEdgeFaces(edges.front()).size())) +
              ", or two faces of opposite orientation; Embree does not smooth such edges\n";
}

/* Vertices that are not manifold although their edges are. */
void warnOfVertices(const Cage& cage, const Far::TopologyLevel& level, std::string& warnings) {
  std::vector<int> vertices;
  for (int vertex = 0; vertex < level.GetNumVertices(); vertex++) {
    const Far::ConstIndexArray edges = level.GetVertexEdges(vertex);
    if (level.GetVertexFaces(vertex).size() > 0 && level.IsVertexNonManifold(vertex) &&
        std::none_of(edges.begin(), edges.end(), [&](int edge) { return level.IsEdgeNonManifold(edge); }))
      vertices.push_back(vertex);
  }
  if (!vertices.empty())
    warnings += cage.name + ": not manifold at " + counted(vertices.size(), "vertex", "vertices") + ": vertex " +
                std::to_string(vertices.front() + 1) +
                " joins parts that share no edge; Embree smooths each part, OpenSubdiv smooths none\n";
}

void warnOfCreases(const Cage& cage, std::string& warnings) {
  const std::vector<unsigned> vertices = findVerticesWithDifferentCreaseRules(cage);
  if (!vertices.empty())
    warnings += cage.name + ": creases meet at " + counted(vertices.size(), "vertex", "vertices") + ", " +
                (vertices.size() == 1 ? "" : "for example ") + std::to_string(vertices.front() + 1) +
                ", where Embree reduces their sharpness by a different rule than OpenSubdiv: nearby, errors against " +
                "the true surface include the difference\n";
}

/* Edges at which the surface ends in Embree: of one face that is no hole. */
std::vector<char> findBorders(const Cage& cage, const Far::TopologyLevel& level) {
  std::vector<char> isHole(cage.numFaces(), 0);
  for (unsigned face : cage.holes) isHole[face] = 1;
  std::vector<char> isBorder(size_t(level.GetNumEdges()), 0);
  for (int edge = 0; edge < level.GetNumEdges(); edge++) {
    const Far::ConstIndexArray all = level.GetEdgeFaces(edge);
    const auto isFace = [&](int face) { return !isHole[size_t(face)]; };
    isBorder[size_t(edge)] = std::count_if(all.begin(), all.end(), isFace) == 1;
  }
  return isBorder;
}

/* OpenSubdiv smooths across holes as if they were faces, unless their edges are creased. */
void warnOfHoles(const Cage& cage, const Far::TopologyLevel& level, std::string& warnings) {
  if (cage.boundary == BoundaryRule::None) return; // see warnOfBoundary
  const std::vector<char> isBorder = findBorders(cage, level);
  std::set<unsigned> holes;
  for (unsigned hole : cage.holes)
    for (int edge : level.GetFaceEdges(int(hole)))
      if (isBorder[size_t(edge)] && !OpenSubdiv::Sdc::Crease::IsInfinite(level.GetEdgeSharpness(edge)))
        holes.insert(hole);
  if (!holes.empty())
    warnings += cage.name + ": " + counted(holes.size(), "hole", "holes") + ", " +
                (holes.size() == 1 ? "" : "for example ") + "face " + std::to_string(*holes.begin() + 1) +
                ": Embree ends the surface there as at a border, OpenSubdiv smooths it as if the hole were a face; " +
                "errors against the true surface do not include this difference\n";
}

/* Under BoundaryRule::None, Embree leaves out all faces that touch a border or a hole. OpenSubdiv keeps those at holes,
 * and at borders that are infinitely sharp. */
void warnOfBoundary(const Cage& cage, const Far::TopologyLevel& level, std::string& warnings) {
  if (cage.boundary != BoundaryRule::None) return;
  const std::vector<char> isBorder = findBorders(cage, level);
  std::vector<int> lost;
  for (int face = 0; face < level.GetNumFaces(); face++) {
    const Far::ConstIndexArray vertices = level.GetFaceVertices(face);
    if (!level.IsFaceHole(face) && std::any_of(vertices.begin(), vertices.end(), [&](int vertex) {
          const Far::ConstIndexArray edges = level.GetVertexEdges(vertex);
          return std::any_of(edges.begin(), edges.end(), [&](int edge) { return isBorder[size_t(edge)]; });
        }))
      lost.push_back(face);
  }
  if (!lost.empty())
    warnings += cage.name + ": " + faces(lost.size()) + " at borders or holes, " +
                (lost.size() == 1 ? "" : "for example ") + "face " + std::to_string(lost.front() + 1) +
                ": left out by Embree under boundary rule 0 (none), but not by OpenSubdiv; expected rule 1 (edge and " +
                "corner) or 2 (edge only)\n";
}

/* Groups the faces at a vertex that manifold edges connect, as Embree does. */
std::vector<std::vector<unsigned>> ringsAt(const Far::TopologyLevel& level, int vertex) {
  std::vector<std::vector<unsigned>> rings;
  const Far::ConstIndexArray all = level.GetVertexFaces(vertex);
  std::set<int> waiting(all.begin(), all.end());
  while (!waiting.empty()) {
    std::vector<unsigned> ring{unsigned(*waiting.begin())};
    waiting.erase(waiting.begin());
    for (size_t i = 0; i < ring.size(); i++)
      for (int edge : level.GetFaceEdges(int(ring[i]))) {
        const Far::ConstIndexArray ends = level.GetEdgeVertices(edge);
        if (level.IsEdgeNonManifold(edge) || (ends[0] != vertex && ends[1] != vertex)) continue;
        for (int face : level.GetEdgeFaces(edge))
          if (waiting.erase(face)) ring.push_back(unsigned(face));
      }
    rings.push_back(std::move(ring));
  }
  return rings;
}

/* Describes the first of several faces or vertices. */
struct Findings {
  std::string first;
  size_t others = 0;

  void add(const std::string& description) {
    if (first.empty()) first = description;
    else others++;
  }
};

/* Embree would also leave out all faces that share a vertex with a face of too many vertices. */
void turnIntoHoles(Cage& cage, const Far::TopologyLevel& level, std::string& warnings) {
  std::vector<char> isHole(cage.numFaces(), 0);
  for (unsigned face : cage.holes) isHole[face] = 1;
  const auto cut = [&](size_t face) {
    if (!isHole[face]) cage.holes.push_back(unsigned(face));
    isHole[face] = 1;
  };
  Findings large, crowded;
  for (size_t face = 0; face < cage.numFaces(); face++)
    if (cage.faceSizes[face] > maxFaceVertices && !isHole[face]) {
      cut(face);
      large.add("face " + std::to_string(face + 1) + " has " + std::to_string(cage.faceSizes[face]) +
                " vertices and is");
    }
  for (int vertex = 0; vertex < level.GetNumVertices(); vertex++) {
    if (level.GetVertexFaces(vertex).size() <= maxVertexFaces) continue;
    for (const std::vector<unsigned>& ring : ringsAt(level, vertex)) {
      if (ring.size() <= maxVertexFaces) continue;
      for (unsigned face : ring) cut(face);
      crowded.add("vertex " + std::to_string(vertex + 1) + " has " + faces(ring.size()) + " around it, which are");
    }
  }
  const auto warn = [&](const Findings& found, const std::string& others, unsigned limit) {
    if (!found.first.empty())
      warnings += cage.name + ": " + found.first + " left out" + (found.others ? ", like " + others : "") +
                  ": Embree supports at most " + std::to_string(limit) + "\n";
  };
  warn(large, counted(large.others, "other face", "other faces"), maxFaceVertices);
  warn(crowded, "the faces around " + counted(crowded.others, "other vertex", "other vertices"), maxVertexFaces);
  if (std::find(isHole.begin(), isHole.end(), 0) == isHole.end())
    throw Error(cage.name + ": no face is left: all are holes or exceed Embree's limits of " +
                std::to_string(maxFaceVertices) + " vertices per face and " + std::to_string(maxVertexFaces) +
                " faces around a vertex; expected at least one other face");
}

} // namespace

void validateCage(Cage& cage, std::string& warnings) {
  checkFaces(cage);
  if (cage.bounds().diagonal() == 0.0f)
    warnings += cage.name + ": all vertices have the same position: there is nothing to see\n";
  removeCreasesWithoutEdge(cage, warnings);
  const std::unique_ptr<Far::TopologyRefiner> refiner = makeRefiner(cage);
  const Far::TopologyLevel level = refiner->GetLevel(0);
  warnOfEdges(cage, level, warnings);
  warnOfVertices(cage, level, warnings);
  warnOfCreases(cage, warnings);
  warnOfHoles(cage, level, warnings);
  warnOfBoundary(cage, level, warnings);
  turnIntoHoles(cage, level, warnings);
}

} // namespace programs
