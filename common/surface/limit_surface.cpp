// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/limit_surface.h"
#include "surface/topology_refiner.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surfaceFactoryCache.h>

#include <mutex>
#include <shared_mutex>

namespace cbvh {
namespace {

namespace Bfr = OpenSubdiv::Bfr;

constexpr int refinement = 10;

using Cache = Bfr::SurfaceFactoryCacheThreaded<std::shared_mutex, std::shared_lock<std::shared_mutex>,
                                               std::unique_lock<std::shared_mutex>>;
using Factory = Bfr::RefinerSurfaceFactory<Cache>;

Factory::Options factoryOptions()
{
  Factory::Options options;
  options.SetApproxLevelSmooth(refinement);
  options.SetApproxLevelSharp(refinement);
  return options;
}

/* numberOf maps faces to those that remain. */
Cage withoutHoles(const Cage& cage, const std::vector<int>& numberOf)
{
  Cage rest;
  rest.positions = cage.positions;
  rest.creaseEdges = cage.creaseEdges;
  rest.creaseSharpness = cage.creaseSharpness;
  rest.cornerVertices = cage.cornerVertices;
  rest.cornerSharpness = cage.cornerSharpness;
  rest.boundary = cage.boundary;
  rest.creaseRule = cage.creaseRule;
  size_t corner = 0;
  for (size_t face = 0; face < cage.numFaces(); corner += cage.faceSizes[face++])
    if (numberOf[face] >= 0)
    {
      rest.faceSizes.push_back(cage.faceSizes[face]);
      const auto first = cage.faceIndices.begin() + ptrdiff_t(corner);
      rest.faceIndices.insert(rest.faceIndices.end(), first, first + cage.faceSizes[face]);
    }
  return rest;
}

/* New number per face, -1 for holes. */
std::vector<int> numbersWithoutHoles(const Cage& cage)
{
  std::vector<int> numbers(cage.numFaces(), 0);
  for (unsigned hole : cage.holes)
    numbers[hole] = -1;
  int next = 0;
  for (int& number : numbers)
    if (number == 0)
      number = next++;
  return numbers;
}

struct Face
{
  std::once_flag prepared;
  Bfr::Surface<double> surface;
  std::vector<double> points; // x, y, z
};

} // namespace

struct LimitSurface::Implementation
{
  explicit Implementation(const Cage& cage)
    : numberOf(numbersWithoutHoles(cage)), refiner(makeTopologyRefiner(withoutHoles(cage, numberOf), false)),
      factory(*refiner, factoryOptions()), faces(new Face[cage.numFaces()])
  {
    for (const Vec3f& p : cage.positions)
      positions.insert(positions.end(), {p.x, p.y, p.z});
  }

  const Face& face(unsigned index) const
  {
    Face& face = faces[index];
    std::call_once(face.prepared, [&] {
      if (!factory.InitVertexSurface(numberOf[index], &face.surface))
        return;
      face.points.resize(size_t(face.surface.GetNumPatchPoints()) * 3);
      face.surface.PreparePatchPoints(positions.data(), 3, face.points.data(), 3);
    });
    return face;
  }

  std::vector<int> numberOf;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
  Factory factory;
  std::vector<double> positions;
  std::unique_ptr<Face[]> faces;
};

LimitSurface::LimitSurface(const Cage& cage) : implementation(std::make_unique<Implementation>(cage)) {}

LimitSurface::~LimitSurface() = default;

bool LimitSurface::has(unsigned face) const
{
  const int number = implementation->numberOf[face];
  return number >= 0 && implementation->factory.FaceHasLimitSurface(number);
}

LimitSample LimitSurface::evaluate(const PatchPoint& p) const
{
  const Face& face = implementation->face(p.face);
  double uv[2] = {p.u, p.v}, scale = 1.0;
  const Bfr::Parameterization parameters = face.surface.GetParameterization();
  if (parameters.HasSubFaces())
  {
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

} // namespace cbvh
