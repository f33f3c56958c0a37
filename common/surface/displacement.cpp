// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/displacement.h"
#include "basics/error.h"
#include "surface/face_borders.h"

#include <map>
#include <tuple>

namespace cbvh {
namespace {

float spacing(int level)
{
  return std::ldexp(1.0f, -level);
}

/* A texture coordinate and how fast it changes there, both a unit of (u,v). */
struct Coordinate
{
  Vec2f uv, width;
};

Coordinate operator+(const Coordinate& a, const Coordinate& b) { return {a.uv + b.uv, a.width + b.width}; }
Coordinate operator*(const Coordinate& a, float s) { return {a.uv * s, a.width * s}; }

/* The width of the filter is interpolated from corners, where it is the mean over all
 * faces that have the same coordinate at the same vertex: like the coordinates, it
 * depends on an edge alone where both sides agree. */
class UVDisplacement : public Displacement
{
public:
  UVDisplacement(const Cage& cage, const std::string& path, float scale)
    : map(path, TextureWrap::Repeat), scale(scale), borders(cage), corners(cage.faceIndices.size()),
      edgeDiffers(corners.size()), cornerDiffers(corners.size())
  {
    findWidths(cage);
    findSeams();
  }

  void offsets(const SurfacePoints& points, float* out) const override
  {
    for (size_t i = 0; i < points.n; i++)
    {
      const FacePoint p{points.face, points.u[i], points.v[i]};
      float height = sample(p, points.level);
      const FaceBorders::Place at = borders.place(p);
      if (at.edge >= 0 && isSeam(p.face, at))
        height = borders.mean(p.face, at, height, [&](const FacePoint& q) { return sample(q, points.level); });
      out[i] = scale * (height - neutralHeight);
    }
  }

private:
  void findWidths(const Cage& cage)
  {
    struct Sum
    {
      Vec2f width;
      float count = 0;
    };
    std::map<std::tuple<unsigned, float, float>, Sum> sums;
    const auto key = [&](size_t c) {
      const Vec2f uv = cage.uvs[cage.uvIndices[c]];
      return std::make_tuple(cage.faceIndices[c], uv.x, uv.y);
    };
    for (unsigned face = 0; face < cage.numFaces(); face++)
      for (unsigned i = 0, n = cage.faceSizes[face]; i < n; i++)
      {
        const size_t c = borders.corner(face, i);
        const Vec2f uv = cage.uvs[cage.uvIndices[c]];
        Sum& sum = sums[key(c)];
        Vec2f width;
        for (unsigned j : {i + 1, i + n - 1})
        {
          const Vec2f d = cage.uvs[cage.uvIndices[borders.corner(face, j % n)]] - uv;
          width = {std::max(width.x, std::abs(d.x)), std::max(width.y, std::abs(d.y))};
        }
        sum.width = sum.width + width;
        sum.count++;
      }
    for (size_t c = 0; c < corners.size(); c++)
    {
      const Sum& sum = sums[key(c)];
      corners[c] = {cage.uvs[cage.uvIndices[c]], sum.width * (1.0f / sum.count)};
    }
  }

  /* Edges and corners where not all sides have the same coordinates. */
  void findSeams()
  {
    const auto same = [&](size_t a, size_t b) {
      return corners[a].uv.x == corners[b].uv.x && corners[a].uv.y == corners[b].uv.y;
    };
    for (unsigned face = 0; borders.numFaces() > face; face++)
      for (unsigned i = 0, n = borders.size(face); i < n; i++)
      {
        const size_t c = borders.corner(face, i);
        for (const FaceBorders::Side& s : borders.around(face, i))
          cornerDiffers[c] |= !same(c, borders.corner(s.face, s.edge));
        const FaceBorders::Side other = borders.opposite(face, i);
        if (other.face != ~0u)
          edgeDiffers[c] = !same(c, borders.corner(other.face, (other.edge + 1) % borders.size(other.face))) ||
                           !same(borders.corner(face, (i + 1) % n), borders.corner(other.face, other.edge));
      }
  }

  bool isSeam(unsigned face, FaceBorders::Place at) const
  {
    const unsigned edge = unsigned(at.edge);
    if (at.t == 0.0f)
      return cornerDiffers[borders.corner(face, edge)];
    if (at.t == 1.0f)
      return cornerDiffers[borders.corner(face, (edge + 1) % borders.size(face))];
    return edgeDiffers[borders.corner(face, edge)];
  }

  float sample(const FacePoint& p, int level) const
  {
    const Coordinate* c = &corners[borders.corner(p.face, 0)];
    const unsigned n = borders.size(p.face);
    float x = p.u, y = p.v;
    Coordinate q[4];
    if (n == 4)
      std::copy(c, c + 4, q);
    else
      cornerQuad(c, n, std::min(decodeSubPatch(x, y), n - 1), q);
    const Coordinate at = bilinear(q, x, y);
    const float h = spacing(level);
    return map.sample(0, at.uv.x, 1.0f - at.uv.y, h * at.width.x, h * at.width.y);
  }

  /* Symmetric in the two ends of an edge: the weights of the far edge are exact
   * zeros there, and 1-x is exact for the multiples of 2^-k that x takes. */
  static Coordinate bilinear(const Coordinate q[4], float x, float y)
  {
    const Coordinate lower = q[0] * (1.0f - x) + q[1] * x;
    const Coordinate upper = q[3] * (1.0f - x) + q[2] * x;
    return lower * (1.0f - y) + upper * y;
  }

  /* One linear subdivision step: corner, middle of the edge ahead, centre, middle
   * of the edge behind. */
  static void cornerQuad(const Coordinate* c, unsigned size, unsigned corner, Coordinate q[4])
  {
    Coordinate centre;
    for (unsigned i = 0; i < size; i++)
      centre = centre + c[i];
    q[0] = c[corner];
    q[1] = (c[corner] + c[(corner + 1) % size]) * 0.5f;
    q[2] = centre * (1.0f / float(size));
    q[3] = (c[corner] + c[(corner + size - 1) % size]) * 0.5f;
  }

  HeightTexture map;
  float scale;
  FaceBorders borders;
  std::vector<Coordinate> corners;             // of faces, in the cage's order
  std::vector<char> edgeDiffers, cornerDiffers;
};

class FaceDisplacement : public Displacement
{
public:
  FaceDisplacement(const Cage& cage, const std::string& path, float scale)
    : map(path, TextureWrap::Clamp), scale(scale), borders(cage)
  {
    unsigned images = 0;
    for (unsigned size : cage.faceSizes)
    {
      firstImage.push_back(images);
      images += size == 4 ? 1 : size;
    }
    if (map.numImages() > 1 && map.numImages() < images)
      throw Error(path + ": has " + std::to_string(map.numImages()) + " images, " + cage.name + " needs " +
                  std::to_string(images) + ", one a quad and n an n-gon, or a single one for all");
  }

  bool closesBorders() const { return map.numImages() == 1 && !map.hasConstantBorder(); }

  void offsets(const SurfacePoints& points, float* out) const override
  {
    for (size_t i = 0; i < points.n; i++)
    {
      const FacePoint p{points.face, points.u[i], points.v[i]};
      float height = sample(p, points.level);
      const FaceBorders::Place at = borders.place(p);
      if (at.edge >= 0)
        height = borders.mean(p.face, at, height, [&](const FacePoint& q) { return sample(q, points.level); });
      out[i] = scale * (height - neutralHeight);
    }
  }

private:
  float sample(const FacePoint& p, int level) const
  {
    float u = p.u, v = p.v, h = spacing(level);
    unsigned corner = 0;
    if (borders.size(p.face) != 4)
    {
      corner = std::min(decodeSubPatch(u, v), borders.size(p.face) - 1);
      h *= 2.0f; // half a face on each axis
    }
    return map.sample(map.numImages() > 1 ? firstImage[p.face] + corner : 0, u, v, h, h);
  }

  HeightTexture map;
  float scale;
  FaceBorders borders;
  std::vector<unsigned> firstImage;
};

} // namespace

std::unique_ptr<Displacement> displaceByUVs(const Cage& cage, const std::string& path, float scale)
{
  if (!cage.hasUVs())
    throw Error(cage.name + ": has no texture coordinates");
  return std::make_unique<UVDisplacement>(cage, path, scale);
}

std::unique_ptr<Displacement> displaceByFace(const Cage& cage, const std::string& path, float scale,
                                             std::string& warning)
{
  auto displacement = std::make_unique<FaceDisplacement>(cage, path, scale);
  if (displacement->closesBorders())
    warning = cage.name + " has no texture coordinates: each face gets the whole of " + path +
              ", and the mean of both sides on its borders, as the border of the map is not of one height";
  return displacement;
}

} // namespace cbvh
