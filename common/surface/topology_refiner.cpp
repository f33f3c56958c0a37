// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/topology_refiner.h"

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

namespace programs {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

namespace {

Sdc::Options schemeOptions(const Cage& cage) {
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(cage.boundary == BoundaryRule::None ? Sdc::Options::VTX_BOUNDARY_NONE
                                      : cage.boundary == BoundaryRule::EdgeAndCorner
                                          ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                          : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  if (cage.creaseRule == CreaseRule::Chaikin) options.SetCreasingMethod(Sdc::Options::CREASE_CHAIKIN);
  return options;
}

} // namespace

std::unique_ptr<Far::TopologyRefiner> makeTopologyRefiner(const Cage& cage, bool validate) {
  const std::vector<int> sizes(cage.faceSizes.begin(), cage.faceSizes.end());
  const std::vector<Far::Index> indices(cage.faceIndices.begin(), cage.faceIndices.end());
  const std::vector<Far::Index> uvIndices(cage.uvIndices.begin(), cage.uvIndices.end());
  const std::vector<Far::Index> corners(cage.cornerVertices.begin(), cage.cornerVertices.end());
  const std::vector<Far::Index> holes(cage.holes.begin(), cage.holes.end());
  std::vector<Far::Index> creases;
  for (auto [a, b] : cage.creaseEdges) {
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
  if (cage.numFacesWithoutUVs() == 0) // OpenSubdiv needs values at all corners
  {
    channel.numValues = int(cage.uvs.size());
    channel.valueIndices = uvIndices.data();
    descriptor.numFVarChannels = 1;
    descriptor.fvarChannels = &channel;
  }

  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  Factory::Options options(Sdc::SCHEME_CATMARK, schemeOptions(cage));
  options.validateFullTopology = validate;
  return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(descriptor, options));
}

} // namespace programs
