// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/mapped_texture.h"
#include "basics/error.h"
#include "surface/udim_tiles.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace programs {
namespace {

float spacing(float level) {
  return std::exp2(-level); // exact for whole levels
}

TextureChannels channelsOf(const DisplacementMap& map) {
  return {map.channel, map.values == MapValues::Heights ? 1 : 3, midLevelOf(map)};
}

void warn(std::string& warnings, const std::string& line) { warnings += line + "\n"; }

void warnOfNormals(const HeightTexture& texture, const DisplacementMap& map, std::string& warnings) {
  if (map.values == MapValues::Heights && map.channel.empty() && texture.looksLikeNormals())
    warn(warnings, map.path + " looks like a normal map; its first channel is read as heights, expected a height map");
}

/* A texture coordinate and its rate of change per unit of (u,v). */
struct Coordinate {
  Vec2f uv, width;
};

Coordinate operator+(const Coordinate& a, const Coordinate& b) { return {a.uv + b.uv, a.width + b.width}; }
Coordinate operator*(const Coordinate& a, float s) { return {a.uv * s, a.width * s}; }

/* The filter width is interpolated from corners, where it is the mean over all faces with the same vertex and
 * coordinate. So on an edge without a seam it depends on the edge alone. */
class UVMappedTexture : public MappedTexture {
public:
  UVMappedTexture(const Cage& cage, const DisplacementMap& map, std::string& warnings)
    : MappedTexture(cage),
      tiles(UdimTiles::find(cage, map.path, warnings)),
      wrap(map.wrap.value_or(tiles.isUdim() ? TextureWrap::Clamp : TextureWrap::Repeat)),
      texture(tiles.paths, channelsOf(map), wrap, warnings),
      corners(findCoordinates(cage, map.repeat)),
      charts(cage, faceBorders, coordinates(), tiles, wrap == TextureWrap::Repeat),
      filter(texture, charts) {
    warnOfNormals(texture, map, warnings);
    if (!tiles.isUdim() && texture.numImages() > 1)
      warn(warnings, map.path + " has " + std::to_string(texture.numImages()) + " images, but " + cage.name +
                         " has texture coordinates: only the first one is read; expected one image, or the option " +
                         "for the channel as PART.CHANNEL for a part of an OpenEXR file");
  }

  void sample(const FacePoint& p, float level, float* values) const override {
    const int image = tiles.imageOf(p.face);
    if (image < 0) return;
    const Coordinate at = interpolate(&corners[faceBorders.corner(p.face, 0)], faceBorders.size(p.face), p);
    const Vec2f uv = at.uv - tiles.originOf(p.face);
    const float h = spacing(level);
    filter.sample(unsigned(image), charts.chartOf(p.face), {uv.x, 1.0f - uv.y}, at.width * h, values);
  }

  float texelsAlongEdge(unsigned face, unsigned edge) const override {
    const int image = tiles.imageOf(face);
    if (image < 0) return 1.0f;
    const unsigned n = faceBorders.size(face);
    const Vec2f d = corners[faceBorders.corner(face, (edge + 1) % n)].uv - corners[faceBorders.corner(face, edge)].uv;
    const Vec2f size = texture.size(unsigned(image));
    return std::hypot(size.x * d.x, size.y * d.y);
  }

  bool isSeam(unsigned face, FaceBorders::BorderPosition at) const override {
    const unsigned edge = unsigned(at.edge);
    if (at.t == 0.0f) return charts.cornerDiffers(faceBorders.corner(face, edge));
    if (at.t == 1.0f) return charts.cornerDiffers(faceBorders.corner(face, (edge + 1) % faceBorders.size(face)));
    return charts.edgeDiffers(faceBorders.corner(face, edge));
  }

private:
  std::vector<Coordinate> findCoordinates(const Cage& cage, Vec2f repeat) const {
    struct Sum {
      Vec2f width;
      float count = 0;
    };
    std::map<std::tuple<unsigned, float, float>, Sum> sums;
    const auto uvAt = [&](size_t c) {
      const Vec2f uv = cage.uvs[cage.uvIndices[c]];
      return Vec2f{repeat.x * uv.x, repeat.y * uv.y};
    };
    const auto key = [&](size_t c) { return std::make_tuple(cage.faceIndices[c], uvAt(c).x, uvAt(c).y); };
    for (unsigned face = 0; face < cage.numFaces(); face++)
      for (unsigned i = 0, n = cage.faceSizes[face]; i < n; i++) {
        const size_t c = faceBorders.corner(face, i);
        Sum& sum = sums[key(c)];
        Vec2f width;
        for (unsigned j : {i + 1, i + n - 1}) {
          const Vec2f d = uvAt(faceBorders.corner(face, j % n)) - uvAt(c);
          width = {std::max(width.x, std::abs(d.x)), std::max(width.y, std::abs(d.y))};
        }
        sum.width = sum.width + width;
        sum.count++;
      }
    std::vector<Coordinate> found;
    for (size_t c = 0; c < cage.faceIndices.size(); c++) {
      const Sum& sum = sums[key(c)];
      found.push_back({uvAt(c), sum.width * (1.0f / sum.count)});
    }
    return found;
  }

  std::vector<Vec2f> coordinates() const {
    std::vector<Vec2f> uvs;
    for (const Coordinate& c : corners) uvs.push_back(c.uv);
    return uvs;
  }

  UdimTiles tiles;
  TextureWrap wrap;
  HeightTexture texture;
  std::vector<Coordinate> corners;
  TextureCharts charts;
  ChartFilter filter;
};

class FaceMappedTexture : public MappedTexture {
public:
  FaceMappedTexture(const Cage& cage, const DisplacementMap& map, std::string& warnings)
    : MappedTexture(cage),
      texture({map.path}, channelsOf(map),
              map.wrap.value_or(isRepeated(map) ? TextureWrap::Repeat : TextureWrap::Clamp), warnings),
      repeat(map.repeat) {
    warnOfNormals(texture, map, warnings);
    unsigned images = 0;
    for (unsigned size : cage.faceSizes) {
      firstImage.push_back(images);
      images += size == 4 ? 1 : size;
    }
    if (texture.numImages() > 1 && texture.numImages() < images)
      throw Error(map.path + ": the file has " + std::to_string(texture.numImages()) + " images, but " + cage.name +
                  " expects " + std::to_string(images) + " (one per quad and n per n-gon), or one for all faces");
    if (texture.numImages() == 1 && !texture.hasConstantBorder())
      warn(warnings,
           cage.name + " has no texture coordinates: each face gets the whole of " + map.path +
               "; the heights on the border of the map differ, so borders of faces use the mean of both sides");
  }

  void sample(const FacePoint& p, float level, float* values) const override {
    float u = p.u, v = p.v, h = spacing(level);
    unsigned corner = 0;
    if (faceBorders.size(p.face) != 4) {
      corner = std::min(decodeSubPatch(u, v), faceBorders.size(p.face) - 1);
      h *= 2.0f; // a corner quad is half a face wide
    }
    texture.sample(texture.numImages() > 1 ? firstImage[p.face] + corner : 0, repeat.x * u, repeat.y * v, repeat.x * h,
                   repeat.y * h, values);
  }

  float texelsAlongEdge(unsigned face, unsigned edge) const override {
    const unsigned n = faceBorders.size(face);
    const Vec2f size = texture.size(texture.numImages() > 1 ? firstImage[face] + (n == 4 ? 0 : edge) : 0);
    const Vec2f texels{repeat.x * size.x, repeat.y * size.y};
    return n != 4 ? 2.0f * std::max(texels.x, texels.y) : edge % 2 == 0 ? texels.x : texels.y;
  }

  bool isSeam(unsigned, FaceBorders::BorderPosition) const override { return true; }

private:
  static bool isRepeated(const DisplacementMap& map) { return map.repeat.x != 1.0f || map.repeat.y != 1.0f; }

  HeightTexture texture;
  Vec2f repeat;
  std::vector<unsigned> firstImage;
};

void requireAllUVs(const Cage& cage, const DisplacementMap& map) {
  const size_t without = cage.numFacesWithoutUVs();
  if (!cage.hasUVs() || without == 0) return;
  const std::string place = cage.lineWithoutUVs ? cage.name + ":" + std::to_string(cage.lineWithoutUVs) : cage.name;
  throw Error(place + ": " + (cage.lineWithoutUVs ? "this face has" : "there are faces that have") +
              " no texture coordinates, and " + map.path + " needs them on all faces; " + std::to_string(without) +
              " of " + std::to_string(cage.numFaces()) + (without == 1 ? " has" : " have") + " none");
}

} // namespace

MappedTexture::MappedTexture(const Cage& cage) : faceBorders(cage) {
  for (unsigned face = 0; face < faceBorders.numFaces(); face++)
    for (unsigned i = 0, n = faceBorders.size(face); i < n; i++)
      edgeLengths.push_back(length(cage.positions[cage.faceIndices[faceBorders.corner(face, (i + 1) % n)]] -
                                   cage.positions[cage.faceIndices[faceBorders.corner(face, i)]]));
}

float MappedTexture::edgeLength(unsigned face, FaceBorders::BorderPosition at) const {
  const unsigned edge = unsigned(at.edge), n = faceBorders.size(face);
  if (at.t != 0.0f && at.t != 1.0f) return edgeLengths[faceBorders.corner(face, edge)];
  float longest = 0;
  for (const FaceBorders::Side& s : faceBorders.cornersAtVertex(face, at.t == 0.0f ? edge : (edge + 1) % n))
    for (unsigned i : {s.edge, (s.edge + faceBorders.size(s.face) - 1) % faceBorders.size(s.face)})
      longest = std::max(longest, edgeLengths[faceBorders.corner(s.face, i)]);
  return longest;
}

std::unique_ptr<MappedTexture> MappedTexture::create(const Cage& cage, const DisplacementMap& map,
                                                     std::string& warnings) {
  requireAllUVs(cage, map);
  if (cage.hasUVs()) return std::make_unique<UVMappedTexture>(cage, map, warnings);
  if (isUdimPath(map.path))
    throw Error(cage.name + ": the cage has no texture coordinates, but the tiles of " + map.path + " need them");
  return std::make_unique<FaceMappedTexture>(cage, map, warnings);
}

} // namespace programs
