// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/cage_validation.h"
#include "basics/error.h"
#include "surface/topology_refiner.h"

#include <opensubdiv/far/error.h>

#include <memory>
#include <string>

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

/* What can be said without topology, in the words of the face. */
void checkFaces(const Cage& cage)
{
  size_t offset = 0;
  for (size_t face = 0; face < cage.numFaces(); offset += cage.faceSizes[face++])
  {
    const unsigned size = cage.faceSizes[face];
    if (size > maxFaceVertices)
      throw Error(cage.name + ": face " + std::to_string(face + 1) + " has " + std::to_string(size) +
                  " vertices, Embree takes at most " + std::to_string(maxFaceVertices));
    for (unsigned i = 0; i < size; i++)
      for (unsigned j = i + 1; j < size; j++)
        if (cage.faceIndices[offset + i] == cage.faceIndices[offset + j])
          throw Error(cage.name + ": face " + std::to_string(face + 1) + " names vertex " +
                      std::to_string(cage.faceIndices[offset + i] + 1) + " twice");
  }
}

} // namespace

void validateCage(const Cage& cage)
{
  checkFaces(cage);

  lastReport.clear();
  Far::SetErrorCallback(keepReport);
  Far::SetWarningCallback(keepWarning);
  const std::unique_ptr<Far::TopologyRefiner> refiner = makeTopologyRefiner(cage, true);
  Far::SetErrorCallback(nullptr);
  Far::SetWarningCallback(nullptr);
  if (!refiner || !lastReport.empty())
    throw Error(cage.name + ": OpenSubdiv: " + oneLine(lastReport.empty() ? "invalid topology" : lastReport));

  const Far::TopologyLevel level = refiner->GetLevel(0);
  for (int edge = 0; edge < level.GetNumEdges(); edge++)
    if (level.IsEdgeNonManifold(edge))
    {
      const Far::ConstIndexArray v = level.GetEdgeVertices(edge);
      throw Error(cage.name + ": not manifold: the edge from vertex " + std::to_string(v[0] + 1) + " to " +
                  std::to_string(v[1] + 1) + " has " + std::to_string(level.GetEdgeFaces(edge).size()) +
                  " faces, or two that run through it the same way");
    }
  for (int vertex = 0; vertex < level.GetNumVertices(); vertex++)
    if (level.GetVertexFaces(vertex).size() > maxVertexFaces)
      throw Error(cage.name + ": vertex " + std::to_string(vertex + 1) + " has " +
                  std::to_string(level.GetVertexFaces(vertex).size()) + " faces around it, Embree takes at most " +
                  std::to_string(maxVertexFaces));
}

} // namespace cbvh
