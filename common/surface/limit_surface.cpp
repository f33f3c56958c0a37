// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/limit_surface.h"
#include "surface/face_borders.h"
#include "surface/topology_refiner.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surfaceFactoryCache.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <shared_mutex>
#include <utility>

namespace programs {
namespace {

namespace Bfr = OpenSubdiv::Bfr;

constexpr int refinement = 10;

using Cache = Bfr::SurfaceFactoryCacheThreaded<std::shared_mutex, std::shared_lock<std::shared_mutex>,
                                               std::unique_lock<std::shared_mutex>>;
using Factory = Bfr::RefinerSurfaceFactory<Cache>;

Factory::Options factoryOptions() {
  Factory::Options options;
  options.SetApproxLevelSmooth(refinement);
  options.SetApproxLevelSharp(refinement);
  return options;
}

/* numberOf maps faces to those that remain. OpenSubdiv prints a warning for each crease without a face. */
Cage withoutHoles(const Cage& cage, const std::vector<int>& numberOf) {
  Cage rest;
  rest.positions = cage.positions;
  rest.cornerVertices = cage.cornerVertices;
  rest.cornerSharpness = cage.cornerSharpness;
  rest.boundary = cage.boundary;
  rest.creaseRule = cage.creaseRule;
  size_t corner = 0;
  for (size_t face = 0; face < cage.numFaces(); corner += cage.faceSizes[face++])
    if (numberOf[face] >= 0) {
      rest.faceSizes.push_back(cage.faceSizes[face]);
      const auto first = cage.faceIndices.begin() + ptrdiff_t(corner);
      rest.faceIndices.insert(rest.faceIndices.end(), first, first + cage.faceSizes[face]);
    }
  if (cage.creaseEdges.empty()) return rest;
  using Edge = std::pair<unsigned, unsigned>;
  const auto ordered = [](unsigned a, unsigned b) { return Edge(std::min(a, b), std::max(a, b)); };
  std::set<Edge> edges;
  corner = 0;
  for (unsigned size : rest.faceSizes) {
    for (unsigned i = 0; i < size; i++)
      edges.insert(ordered(rest.faceIndices[corner + i], rest.faceIndices[corner + (i + 1) % size]));
    corner += size;
  }
  for (size_t i = 0; i < cage.creaseEdges.size(); i++)
    if (edges.count(ordered(cage.creaseEdges[i].first, cage.creaseEdges[i].second))) {
      rest.creaseEdges.push_back(cage.creaseEdges[i]);
      rest.creaseSharpness.push_back(cage.creaseSharpness[i]);
    }
  return rest;
}

/* New number per face, -1 for holes. */
std::vector<int> numbersWithoutHoles(const Cage& cage) {
  std::vector<int> numbers(cage.numFaces(), 0);
  for (unsigned hole : cage.holes) numbers[hole] = -1;
  int next = 0;
  for (int& number : numbers)
    if (number == 0) number = next++;
  return numbers;
}

/* Marks faces that share two adjacent edges with another face, if a crease ends at one of their vertices: OpenSubdiv
 * 3.5 then reads out of bounds. */
std::vector<char> findUnsupportedFaces(const Cage& cage) {
  std::vector<char> unsupported(cage.numFaces());
  if (cage.creaseEdges.empty()) return unsupported;
  std::vector<char> isCreased(cage.positions.size());
  for (size_t i = 0; i < cage.creaseEdges.size(); i++)
    if (cage.creaseSharpness[i] > 0.0f)
      isCreased[cage.creaseEdges[i].first] = isCreased[cage.creaseEdges[i].second] = 1;
  const FaceBorders borders(cage);
  for (unsigned face = 0; face < cage.numFaces(); face++) {
    bool isWrapped = false, hasCrease = false;
    for (unsigned i = 0, n = borders.size(face); i < n; i++) {
      const unsigned other = borders.opposite(face, i).face;
      isWrapped |= other != ~0u && other == borders.opposite(face, (i + 1) % n).face;
      hasCrease |= isCreased[cage.faceIndices[borders.corner(face, i)]] != 0;
    }
    unsupported[face] = isWrapped && hasCrease;
  }
  return unsupported;
}

struct Face {
  std::once_flag prepared;
  Bfr::Surface<double> surface;
  std::vector<double> points; // x, y, z
};

} // namespace

struct LimitSurface::Implementation {
  explicit Implementation(const Cage& cage) : Implementation(cage, numbersWithoutHoles(cage)) {}

  Implementation(const Cage& cage, const std::vector<int>& numbers)
    : Implementation(withoutHoles(cage, numbers), numbers, cage.numFaces()) {}

  Implementation(const Cage& rest, const std::vector<int>& numbers, size_t numFaces)
    : numberOf(numbers),
      refiner(makeTopologyRefiner(rest, false)),
      factory(*refiner, factoryOptions()),
      isUnsupported(findUnsupportedFaces(rest)),
      faces(new Face[numFaces]) {
    for (const Vec3f& p : rest.positions) positions.insert(positions.end(), {p.x, p.y, p.z});
  }

  const Face& face(unsigned index) const {
    Face& face = faces[index];
    std::call_once(face.prepared, [&] {
      if (!factory.InitVertexSurface(numberOf[index], &face.surface)) return;
      face.points.resize(size_t(face.surface.GetNumPatchPoints()) * 3);
      face.surface.PreparePatchPoints(positions.data(), 3, face.points.data(), 3);
    });
    return face;
  }

  std::vector<int> numberOf;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
  Factory factory;
  std::vector<char> isUnsupported; // by number
  std::vector<double> positions;
  std::unique_ptr<Face[]> faces;
};

LimitSurface::LimitSurface(const Cage& cage) : implementation(std::make_unique<Implementation>(cage)) {}

LimitSurface::~LimitSurface() = default;

bool LimitSurface::has(unsigned face) const {
  const int number = implementation->numberOf[face];
  return number >= 0 && !implementation->isUnsupported[size_t(number)] &&
         implementation->factory.FaceHasLimitSurface(number);
}

LimitSample LimitSurface::evaluate(const PatchPoint& p) const {
  const Face& face = implementation->face(p.face);
  double uv[2] = {p.u, p.v}, scale = 1.0;
  const Bfr::Parameterization parameters = face.surface.GetParameterization();
  if (parameters.HasSubFaces()) {
    /* Bfr's sub-faces are half as wide. */
    const double local[2] = {p.u, p.v};
    parameters.ConvertNormalizedSubFaceToCoord(int(p.subPatch), local, uv);
    scale = 0.5;
  }
  double s[6][3];
  face.surface.Evaluate(uv, face.points.data(), 3, s[0], s[1], s[2], s[3], s[4], s[5]);
  const auto vector = [&](int i, double factor) { return Vec3d{s[i][0], s[i][1], s[i][2]} * factor; };
  const double square = scale * scale;
  return {vector(0, 1.0), vector(1, scale), vector(2, scale), vector(3, square), vector(4, square), vector(5, square)};
}

} // namespace programs
