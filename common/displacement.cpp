// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "displacement.h"
#include "error.h"

#include <utility>

namespace cbvh {
namespace {

class UVDisplacement : public Displacement
{
public:
  UVDisplacement(const Cage& cage, HeightMap map, float scale) : map(std::move(map)), scale(scale)
  {
    if (!cage.hasUVs())
      throw Error(cage.name + ": has no texture coordinates");
    size_t offset = 0;
    for (unsigned size : cage.faceSizes)
    {
      first.push_back(corners.size());
      sizes.push_back(size);
      for (unsigned i = 0; i < size; i++)
        corners.push_back(cage.uvs[cage.uvIndices[offset + i]]);
      offset += size;
    }
  }

  void offsets(unsigned face, size_t n, const float* u, const float* v, float* out) const override
  {
    const Vec2f* c = &corners[first[face]];
    for (size_t i = 0; i < n; i++)
    {
      float x = u[i], y = v[i];
      Vec2f q[4];
      if (sizes[face] == 4)
        std::copy(c, c + 4, q);
      else
        cornerQuad(c, sizes[face], std::min(decodeSubPatch(x, y), sizes[face] - 1), q);
      const Vec2f uv = bilinear(q, x, y);
      out[i] = scale * (map.sampleRepeated(uv.x, uv.y) - neutralHeight);
    }
  }

private:
  /* Symmetric in the two ends of an edge: the weights of the far edge are exact
   * zeros there, and 1-x is exact for the multiples of 2^-k that x takes. */
  static Vec2f bilinear(const Vec2f q[4], float x, float y)
  {
    const Vec2f lower = q[0] * (1.0f - x) + q[1] * x;
    const Vec2f upper = q[3] * (1.0f - x) + q[2] * x;
    return lower * (1.0f - y) + upper * y;
  }

  /* One linear subdivision step: corner, middle of the edge ahead, centre, middle
   * of the edge behind. */
  static void cornerQuad(const Vec2f* c, unsigned size, unsigned corner, Vec2f q[4])
  {
    Vec2f centre;
    for (unsigned i = 0; i < size; i++)
      centre = centre + c[i];
    q[0] = c[corner];
    q[1] = (c[corner] + c[(corner + 1) % size]) * 0.5f;
    q[2] = centre * (1.0f / float(size));
    q[3] = (c[corner] + c[(corner + size - 1) % size]) * 0.5f;
  }

  HeightMap map;
  float scale;
  std::vector<Vec2f> corners;
  std::vector<size_t> first;
  std::vector<unsigned> sizes;
};

class FaceDisplacement : public Displacement
{
public:
  FaceDisplacement(const Cage& cage, HeightMap map, float scale)
    : map(std::move(map)), scale(scale), sizes(cage.faceSizes)
  {
  }

  void offsets(unsigned face, size_t n, const float* u, const float* v, float* out) const override
  {
    for (size_t i = 0; i < n; i++)
    {
      float x = u[i], y = v[i];
      if (sizes[face] != 4)
        decodeSubPatch(x, y);
      /* From centre to centre of the border texels, so that a constant border stays one. */
      const float height = map.sampleTexels(x * float(map.width() - 1), y * float(map.height() - 1));
      out[i] = scale * (height - neutralHeight);
    }
  }

private:
  HeightMap map;
  float scale;
  std::vector<unsigned> sizes;
};

class AtlasDisplacement : public Displacement
{
public:
  AtlasDisplacement(const FaceAtlas& atlas, HeightMap map, float scale)
    : atlas(atlas), map(std::move(map)), scale(scale)
  {
  }

  void offsets(unsigned face, size_t n, const float* u, const float* v, float* out) const override
  {
    const float x0 = float(int(face) % atlas.tilesPerRow * (atlas.tileSize + 1));
    const float y0 = float(int(face) / atlas.tilesPerRow * (atlas.tileSize + 1));
    for (size_t i = 0; i < n; i++)
    {
      const float height = map.sampleTexels(x0 + u[i] * float(atlas.tileSize), y0 + v[i] * float(atlas.tileSize));
      out[i] = scale * (height - neutralHeight);
    }
  }

private:
  FaceAtlas atlas;
  HeightMap map;
  float scale;
};

} // namespace

FaceAtlas FaceAtlas::forFaces(size_t numFaces, int tileSize)
{
  FaceAtlas atlas;
  atlas.tileSize = tileSize;
  atlas.tilesPerRow = std::max(1, int(std::ceil(std::sqrt(double(numFaces)))));
  return atlas;
}

std::unique_ptr<Displacement> displaceByUVs(const Cage& cage, HeightMap map, float scale)
{
  return std::make_unique<UVDisplacement>(cage, std::move(map), scale);
}

std::unique_ptr<Displacement> displaceByFace(const Cage& cage, HeightMap map, float scale)
{
  return std::make_unique<FaceDisplacement>(cage, std::move(map), scale);
}

std::unique_ptr<Displacement> displaceByAtlas(const FaceAtlas& atlas, HeightMap map, float scale)
{
  return std::make_unique<AtlasDisplacement>(atlas, std::move(map), scale);
}

} // namespace cbvh
