// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/face_atlas.h"
#include "surface/face_borders.h"

#include <utility>

namespace programs {
namespace {

/* Keeps every other texel, filtered with a quarter of its neighbors; on a border only along the border. */
HeightMap halved(const HeightMap& map, const FaceAtlas& atlas, const FaceAtlas& half, size_t numFaces) {
  HeightMap result(half.columns(), half.rows(numFaces));
  const int side = atlas.tileSize;
  for (int face = 0; face < int(numFaces); face++) {
    const int x0 = face % atlas.tilesPerRow * (side + 1), y0 = face / atlas.tilesPerRow * (side + 1);
    const int hx0 = face % half.tilesPerRow * (half.tileSize + 1), hy0 = face / half.tilesPerRow * (half.tileSize + 1);
    const auto alongX = [&](int x, int y) {
      const float m = map.at(x0 + x, y0 + y);
      return x == 0 || x == side ? m : 0.5f * m + 0.25f * (map.at(x0 + x - 1, y0 + y) + map.at(x0 + x + 1, y0 + y));
    };
    for (int y = 0; y <= half.tileSize; y++)
      for (int x = 0; x <= half.tileSize; x++) {
        const float m = alongX(2 * x, 2 * y);
        result.at(hx0 + x, hy0 + y) =
            y == 0 || y == half.tileSize ? m : 0.5f * m + 0.25f * (alongX(2 * x, 2 * y - 1) + alongX(2 * x, 2 * y + 1));
      }
  }
  return result;
}

class AtlasDisplacement : public Displacement {
public:
  AtlasDisplacement(const Cage& cage, const FaceAtlas& finest, HeightMap map, float scale) : scale(scale) {
    const FaceBorders borders(cage);
    levels.push_back({finest, std::move(map)});
    while (levels.back().atlas.tileSize % 2 == 0) {
      const Level& last = levels.back();
      FaceAtlas half = last.atlas;
      half.tileSize /= 2;
      Level next{half, halved(last.map, last.atlas, half, cage.numFaces())};
      closeBorders(next, borders);
      levels.push_back(std::move(next));
    }
  }

  void offsets(const SurfacePoints& points, float* out) const override {
    const Level* level = &levels[levelFor(points.level)];
    const auto heightAt = [&](size_t i) { return level->height(points.face, points.u[i], points.v[i]); };
    for (size_t i = 0; i < points.n; i++) {
      if (!points.levels) {
        out[i] = scale * (heightAt(i) - neutralHeight);
        continue;
      }
      const float whole = std::floor(points.levels[i]), part = points.levels[i] - whole;
      level = &levels[levelFor(int(whole))];
      float height = heightAt(i);
      if (part > 0.0f) {
        level = &levels[levelFor(int(whole) + 1)];
        height = height * (1.0f - part) + heightAt(i) * part;
      }
      out[i] = scale * (height - neutralHeight);
    }
  }

  float texelsAlongEdge(unsigned, unsigned) const override { return float(levels[0].atlas.tileSize); }

private:
  struct Level {
    FaceAtlas atlas;
    HeightMap map;

    float height(unsigned face, float u, float v) const {
      const float x0 = float(int(face) % atlas.tilesPerRow * (atlas.tileSize + 1));
      const float y0 = float(int(face) / atlas.tilesPerRow * (atlas.tileSize + 1));
      return map.sampleTexels(x0 + u * float(atlas.tileSize), y0 + v * float(atlas.tileSize));
    }

    float& texel(const FacePoint& p) {
      const int side = atlas.tileSize + 1;
      return map.at(int(p.face) % atlas.tilesPerRow * side + int(std::lround(p.u * float(atlas.tileSize))),
                    int(p.face) / atlas.tilesPerRow * side + int(std::lround(p.v * float(atlas.tileSize))));
    }
  };

  /* The finest mip level whose texels are not narrower than the spacing. */
  size_t levelFor(int level) const {
    size_t k = 0;
    while (k + 1 < levels.size() && levels[k].atlas.tileSize > (1 << std::min(level, finestLevel))) k++;
    return k;
  }

  /* Sets each border texel to the mean of its sides, once all means are computed. */
  static void closeBorders(Level& level, const FaceBorders& borders) {
    const int n = level.atlas.tileSize;
    std::vector<float> means;
    for (bool write : {false, true}) {
      size_t next = 0;
      for (unsigned face = 0; face < borders.numFaces(); face++)
        for (unsigned edge = 0; edge < 4; edge++)
          for (int i = 0; i < n; i++) // the last texel belongs to the next edge
          {
            const float t = float(i) / float(n);
            float& texel = level.texel(borders.point(face, edge, t));
            if (write) texel = means[next++];
            else
              means.push_back(
                  borders.mean(face, {int(edge), t}, texel, [&](const FacePoint& p) { return level.texel(p); }));
          }
    }
  }

  float scale;
  std::vector<Level> levels; // finest first
};

} // namespace

FaceAtlas FaceAtlas::forFaces(size_t numFaces, int tileSize) {
  FaceAtlas atlas;
  atlas.tileSize = tileSize;
  atlas.tilesPerRow = std::max(1, int(std::ceil(std::sqrt(double(numFaces)))));
  return atlas;
}

std::unique_ptr<Displacement> displaceByAtlas(const Cage& cage, const FaceAtlas& atlas, HeightMap map, float scale) {
  return std::make_unique<AtlasDisplacement>(cage, atlas, std::move(map), scale);
}

} // namespace programs
