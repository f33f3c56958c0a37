// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/cage_validation.h"
#include "basics/error.h"
#include "surface/crease_rules.h"
#include "surface/topology_refiner.h"

#include <opensubdiv/far/error.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace cbvh {
namespace {

namespace Far = OpenSubdiv::Far;

/* MAX_PATCH_VALENCE and MAX_RING_FACE_VALENCE of Embree's kernels/subdiv. */
constexpr unsigned maxFaceVertices = 16;
constexpr int maxVertexFaces = 64;

/* OpenSubdiv reports through a plain function, so the text waits here. */
thread_local std::string lastReport;

void keepReport(Far::ErrorType, const char* message)
{
  if (lastReport.empty())
    lastReport = message;
}

void keepWarning(const char* message)
{
  if (lastReport.empty())
    lastReport = message;
}

std::string oneLine(std::string text)
{
  for (char& c : text)
    if (c == '\n')
      c = ' ';
  while (!text.empty() && text.back() == ' ')
    text.pop_back();
  return text;
}

std::string faces(size_t n)
{
  return std::to_string(n) + (n == 1 ? " face" : " faces");
}

/* What can be said without topology, in the words of the face. */
void checkFaces(const Cage& cage)
{
  size_t offset = 0;
  for (size_t face = 0; face < cage.numFaces(); offset += cage.faceSizes[face++])
  {
    const unsigned size = cage.faceSizes[face];
    std::vector<unsigned> vertices(cage.faceIndices.begin() + ptrdiff_t(offset),
                                   cage.faceIndices.begin() + ptrdiff_t(offset + size));
    std::sort(vertices.begin(), vertices.end());
    const auto twice = std::adjacent_find(vertices.begin(), vertices.end());
    if (twice != vertices.end())
      throw Error(cage.name + ": face " + std::to_string(face + 1) + " names vertex " + std::to_string(*twice + 1) +
                  " twice");
  }
}

std::unique_ptr<Far::TopologyRefiner> makeRefiner(const Cage& cage)
{
  lastReport.clear();
  Far::SetErrorCallback(keepReport);
  Far::SetWarningCallback(keepWarning);
  std::unique_ptr<Far::TopologyRefiner> refiner = makeTopologyRefiner(cage, true);
  Far::SetErrorCallback(nullptr);
  Far::SetWarningCallback(nullptr);
  if (!refiner || !lastReport.empty())
    throw Error(cage.name + ": OpenSubdiv: " + oneLine(lastReport.empty() ? "invalid topology" : lastReport));
  return refiner;
}

void warnOfEdges(const Cage& cage, const Far::TopologyLevel& level, std::string& warnings)
{
  size_t count = 0;
  int first = -1;
  for (int edge = 0; edge < level.GetNumEdges(); edge++)
    if (level.IsEdgeNonManifold(edge))
      first = count++ == 0 ? edge : first;
  if (count == 0)
    return;
  const Far::ConstIndexArray v = level.GetEdgeVertices(first);
  warnings += cage.name + ": not manifold at " + std::to_string(count) + (count == 1 ? " edge" : " edges") +
              ": that from vertex " + std::to_string(v[0] + 1) + " to " + std::to_string(v[1] + 1) + " has " +
              faces(size_t(level.GetEdgeFaces(first).size())) +
              ", or two that run through it the same way; Embree does not round such edges\n";
}

void warnOfCreases(const Cage& cage, std::string& warnings)
{
  const std::vector<unsigned> vertices = verticesOfOtherCreaseRules(cage);
  if (!vertices.empty())
    warnings += cage.name + ": creases meet at " + std::to_string(vertices.size()) +
                (vertices.size() == 1 ? " vertex, " : " vertices, ") + std::to_string(vertices.front() + 1) +
                (vertices.size() == 1 ? "" : " for one") +
                ", where Embree has another rule for their sharpness than OpenSubdiv: near them the surface is another, " +
                "and errors against the true surface contain that\n";
}

/* Makes holes of what is beyond Embree's limits. It would leave out such faces, and all that
 * share a vertex with a face of too many vertices. */
void cutOut(Cage& cage, const Far::TopologyLevel& level, std::string& warnings)
{
  std::vector<char> isHole(cage.numFaces(), 0);
  for (unsigned face : cage.holes)
    isHole[face] = 1;
  const auto cut = [&](size_t face) {
    if (!isHole[face])
      cage.holes.push_back(unsigned(face));
    isHole[face] = 1;
  };
  for (size_t face = 0; face < cage.numFaces(); face++)
    if (cage.faceSizes[face] > maxFaceVertices && !isHole[face])
    {
      cut(face);
      warnings += cage.name + ": face " + std::to_string(face + 1) + " has " + std::to_string(cage.faceSizes[face]) +
                  " vertices, Embree takes at most " + std::to_string(maxFaceVertices) + ": it is left out\n";
    }
  for (int vertex = 0; vertex < level.GetNumVertices(); vertex++)
  {
    const Far::ConstIndexArray around = level.GetVertexFaces(vertex);
    if (around.size() <= maxVertexFaces)
      continue;
    for (int face : around)
      cut(size_t(face));
    warnings += cage.name + ": vertex " + std::to_string(vertex + 1) + " has " + faces(size_t(around.size())) +
                " around it, Embree takes at most " + std::to_string(maxVertexFaces) + ": they are left out\n";
  }
  if (cage.holes.size() == cage.numFaces())
    throw Error(cage.name + ": no face is left within Embree's limits, " + std::to_string(maxFaceVertices) +
                " vertices a face and " + std::to_string(maxVertexFaces) + " faces around a vertex");
}

} // namespace

void validateCage(Cage& cage, std::string& warnings)
{
  checkFaces(cage);
  const std::unique_ptr<Far::TopologyRefiner> refiner = makeRefiner(cage);
  const Far::TopologyLevel level = refiner->GetLevel(0);
  warnOfEdges(cage, level, warnings);
  warnOfCreases(cage, warnings);
  cutOut(cage, level, warnings);
}

} // namespace cbvh
