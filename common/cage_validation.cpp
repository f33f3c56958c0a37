// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "cage_validation.h"
#include "error.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <memory>
#include <string>

namespace cbvh {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

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

Sdc::Options schemeOptions(const Cage& cage)
{
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(cage.boundary == BoundaryRule::None ? Sdc::Options::VTX_BOUNDARY_NONE
                                      : cage.boundary == BoundaryRule::EdgeAndCorner
                                        ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                        : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  return options;
}

} // namespace

void validateCage(const Cage& cage)
{
  checkFaces(cage);

  const std::vector<int> sizes(cage.faceSizes.begin(), cage.faceSizes.end());
  const std::vector<Far::Index> indices(cage.faceIndices.begin(), cage.faceIndices.end());
  const std::vector<Far::Index> uvIndices(cage.uvIndices.begin(), cage.uvIndices.end());
  const std::vector<Far::Index> corners(cage.cornerVertices.begin(), cage.cornerVertices.end());
  const std::vector<Far::Index> holes(cage.holes.begin(), cage.holes.end());
  std::vector<Far::Index> creases;
  for (auto [a, b] : cage.creaseEdges)
  {
    creases.push_back(Far::Index(a));
    creases.push_back(Far::Index(b));
  }

  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = int(cage.positions.size());
  descriptor.numFaces = int(sizes.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = indices.data();
  descriptor.numCreases = int(cage.creaseEdges.size());
  descriptor.creaseVertexIndexPairs = creases.data();
  descriptor.creaseWeights = cage.creaseSharpness.data();
  descriptor.numCorners = int(corners.size());
  descriptor.cornerVertexIndices = corners.data();
  descriptor.cornerWeights = cage.cornerSharpness.data();
  descriptor.numHoles = int(holes.size());
  descriptor.holeIndices = holes.data();
  Far::TopologyDescriptor::FVarChannel channel;
  if (cage.hasUVs())
  {
    channel.numValues = int(cage.uvs.size());
    channel.valueIndices = uvIndices.data();
    descriptor.numFVarChannels = 1;
    descriptor.fvarChannels = &channel;
  }

  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  Factory::Options options(Sdc::SCHEME_CATMARK, schemeOptions(cage));
  options.validateFullTopology = true;
  lastReport.clear();
  Far::SetErrorCallback(keepReport);
  Far::SetWarningCallback(keepWarning);
  const std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(descriptor, options));
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
