// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/diced_surface.h"
#include "basics/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <unordered_map>

namespace cbvh {
namespace {

/* Names the points of a cage that several patches have: its vertices, points on its edges, and on spokes and in the centres of n-gons. */
class BorderPoints
{
public:
  explicit BorderPoints(const Cage& cage)
  {
    size_t first = 0;
    for (unsigned size : cage.faceSizes)
    {
      faces.push_back({&cage.faceIndices[first], size});
      first += size;
    }
  }

  using Name = std::array<unsigned, 4>;

  /* Of vertex (x,y) of a patch, on its border. */
  Name name(const Patch& patch, unsigned face, unsigned x, unsigned y) const
  {
    const unsigned n = patch.resolution, size = faces[face].size;
    if (size == 4)
      return y == 0 ? onEdge(face, 0, x, n) : x == n ? onEdge(face, 1, y, n) : y == n ? onEdge(face, 2, n - x, n) : onEdge(face, 3, n - y, n);
    const unsigned corner = patch.subPatch, before = (corner + size - 1) % size;
    if (y == 0)
      return onEdge(face, corner, x, 2 * n);
    if (x == 0)
      return onEdge(face, before, 2 * n - y, 2 * n);
    return x == n ? onSpoke(face, corner, y, n) : onSpoke(face, before, x, n);
  }

private:
  enum Kind : unsigned { Vertex, Edge, Spoke, Centre };

  struct Face
  {
    const unsigned* indices;
    unsigned size;
  };

  Name onEdge(unsigned face, unsigned edge, unsigned k, unsigned steps) const
  {
    const unsigned a = faces[face].indices[edge], b = faces[face].indices[(edge + 1) % faces[face].size];
    if (k == 0 || k == steps)
      return {Vertex, k == 0 ? a : b, 0, 0};
    return a < b ? Name{Edge, a, b, k} : Name{Edge, b, a, steps - k};
  }

  /* from the middle of an edge */
  Name onSpoke(unsigned face, unsigned edge, unsigned k, unsigned steps) const
  {
    if (k == 0)
      return onEdge(face, edge, steps, 2 * steps);
    return k == steps ? Name{Centre, face, 0, 0} : Name{Spoke, face, edge, k};
  }

  std::vector<Face> faces;
};

struct Hash
{
  size_t operator()(const BorderPoints::Name& name) const
  {
    uint64_t h = 0;
    for (unsigned x : name)
      h = (h ^ x) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
    return size_t(h);
  }
};

} // namespace

DicedInput DicedInput::parse(const std::string& text)
{
  DicedInput input;
  input.name = text;
  const std::string word = "grids", quads = text.substr(std::min(text.size(), word.size() + 1));
  if (text == word)
    return input;
  const auto end = std::from_chars(quads.data(), quads.data() + quads.size(), input.gridQuads);
  if (text.compare(0, word.size() + 1, word + ":") != 0 || end.ec != std::errc() || end.ptr != quads.data() + quads.size() || input.gridQuads == 0)
    throw Error("unknown input '" + text + "', known are grids and grids:N, of N x N quads");
  return input;
}

DicedSurface::DicedSurface(const Model& model, const BuildSettings& settings)
  : layout(model.layout(settings.level)), positions(tessellate(model, settings))
{
  const size_t patches = layout.patches().size() / model.copies.size();
  for (size_t i = 0; i < model.copies.size(); i++)
    weld(model.cage, i * patches, patches);
}

void DicedSurface::weld(const Cage& cage, size_t firstPatch, size_t numPatches)
{
  const BorderPoints points(cage);
  std::unordered_map<BorderPoints::Name, size_t, Hash> first;
  for (size_t i = firstPatch; i < firstPatch + numPatches; i++)
  {
    const Patch& patch = layout.patches()[i];
    const unsigned n = patch.resolution, face = unsigned(patch.face % cage.numFaces());
    for (unsigned y = 0; y <= n; y++)
      for (unsigned x = 0; x <= n; x += y == 0 || y == n ? 1 : n)
      {
        const size_t vertex = patch.firstVertex + y * (n + 1) + x;
        positions[vertex] = positions[first.emplace(points.name(patch, face, x, y), vertex).first->second];
      }
  }
}

GeometryHandle DicedSurface::makeGeometry(EmbreeDevice& device, const DicedInput& input) const
{
  GeometryHandle geometry(rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_GRID));
  void* vertices = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), positions.size());
  device.check("allocating vertices");
  std::copy(positions.begin(), positions.end(), static_cast<Vec3f*>(vertices));
  std::vector<RTCGrid> grids;
  for (const Patch& patch : layout.patches())
  {
    const unsigned n = patch.resolution, side = input.gridQuads ? input.gridQuads : n;
    for (unsigned y = 0; y < n; y += side)
      for (unsigned x = 0; x < n; x += side)
        grids.push_back({unsigned(patch.firstVertex + y * (n + 1) + x), n + 1, static_cast<unsigned short>(std::min(side, n - x) + 1),
                         static_cast<unsigned short>(std::min(side, n - y) + 1)});
  }
  void* data = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), grids.size());
  device.check("allocating grids");
  std::copy(grids.begin(), grids.end(), static_cast<RTCGrid*>(data));
  return geometry;
}

} // namespace cbvh
