// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/displacement.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "scenes/cube.h"
#include "support/map_files.h"
#include "support/message_parts.h"
#include "surface/face_atlas.h"
#include "surface/face_borders.h"
#include "surface/obj_reader.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

namespace programs::test { namespace {

/* Two adjacent quads with one atlas: face 0 left, face 1 right. */
Cage twoQuads() {
  Cage cage;
  cage.name = "two";
  cage.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  cage.faceSizes = {4, 4};
  cage.faceIndices = {0, 1, 4, 3, 1, 2, 5, 4};
  cage.uvs = {{0.1f, 0.1f}, {0.45f, 0.13f}, {0.9f, 0.1f}, {0.1f, 0.9f}, {0.55f, 0.87f}, {0.9f, 0.9f}};
  cage.uvIndices = cage.faceIndices;
  return cage;
}

HeightMap ramp(int size) {
  HeightMap map(size, size);
  for (int y = 0; y < size; y++)
    for (int x = 0; x < size; x++) map.at(x, y) = std::sin(0.7f * float(x)) * std::cos(0.3f * float(y));
  return map;
}

/* Heights of a map, read with the default settings. */
std::unique_ptr<Displacement> displaced(const Cage& cage, const std::string& path, float scale) {
  DisplacementMap map;
  map.path = path;
  map.scale = scale;
  std::string warnings;
  return displaceByMap(cage, map, warnings);
}

std::string warningsOf(const Cage& cage, const std::string& path) {
  DisplacementMap map;
  map.path = path;
  std::string warnings;
  displaceByMap(cage, map, warnings);
  return warnings;
}

std::string errorOf(const Cage& cage, const std::string& path) {
  try {
    displaced(cage, path, 1.0f);
  } catch (const Error& e) { return e.what(); }
  return "";
}

Cage withoutUVs(Cage cage) {
  cage.uvs.clear();
  cage.uvIndices.clear();
  return cage;
}

float offset(const Displacement& d, unsigned face, float u, float v, int level = finestLevel) {
  float result;
  d.offsets({face, level, 1, &u, &v}, &result);
  return result;
}

/* Maps in files, in a folder that is removed at the end. */
class Displacing : public MapFiles {
protected:
  std::string path(const HeightMap& map, const std::string& name = "map.exr") {
    map.write((folder / name).string());
    return (folder / name).string();
  }

  /* A TIFF with one page per face. */
  std::string pages(const std::vector<HeightMap>& maps) {
    const std::string file = (folder / "pages.tif").string();
    const auto output = OIIO::ImageOutput::create(file);
    std::vector<OIIO::ImageSpec> specs;
    for (const HeightMap& map : maps) specs.emplace_back(map.width(), map.height(), 1, OIIO::TypeDesc::FLOAT);
    for (size_t i = 0; i < maps.size(); i++) {
      EXPECT_TRUE(i == 0 ? output->open(file, int(specs.size()), specs.data())
                         : output->open(file, specs[i], OIIO::ImageOutput::AppendSubimage));
      std::vector<float> texels;
      for (int y = 0; y < maps[i].height(); y++)
        for (int x = 0; x < maps[i].width(); x++) texels.push_back(maps[i].at(x, y));
      EXPECT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, texels.data()));
    }
    output->close();
    return file;
  }
};

HeightMap flat(int size, float height) {
  HeightMap map(size, size);
  for (int y = 0; y < size; y++)
    for (int x = 0; x < size; x++) map.at(x, y) = height;
  return map;
}

/* A closed prism over a pentagon, without texture coordinates. Its top consists of a triangle and a quad. */
Cage mixedCage() {
  Cage cage;
  cage.name = "mixed";
  for (float z : {0.0f, 1.0f})
    for (int i = 0; i < 5; i++)
      cage.positions.push_back({std::cos(1.2566f * float(i)), std::sin(1.2566f * float(i)), z});
  cage.faceSizes = {5, 4, 4, 4, 4, 4, 3, 4};
  cage.faceIndices = {4, 3, 2, 1, 0, 0, 1, 6, 5, 1, 2, 7, 6, 2, 3, 8, 7, 3, 4, 9, 8, 4, 0, 5, 9, 5, 6, 7, 5, 7, 8, 9};
  return cage;
}

/* Every point of every border, from all of its faces. */
void expectClosed(const Cage& cage, const Displacement& d, int level) {
  const FaceBorders borders(cage);
  const int n = 1 << level;
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned edge = 0; edge < cage.faceSizes[face]; edge++)
      for (int i = 0; i <= n; i++) {
        const float t = float(i) / float(n);
        const FacePoint here = borders.point(face, edge, t);
        const FaceBorders::Side other = borders.opposite(face, edge);
        ASSERT_NE(other.face, ~0u);
        const FacePoint there = borders.point(other.face, other.edge, 1.0f - t);
        ASSERT_EQ(offset(d, face, here.u, here.v, level), offset(d, there.face, there.u, there.v, level))
            << "face " << face << " edge " << edge << " at " << t;
      }
}

TEST_F(Displacing, FacesWithTheSameCoordinatesOnAnEdgeAreClosed) {
  const Cage cage = twoQuads();
  const auto d = displaced(cage, path(ramp(64)), 2.0f);
  for (int level : {3, 5, 8})
    for (int i = 0; i <= 256; i++) // right border of face 0, left border of face 1
      EXPECT_EQ(offset(*d, 0, 1.0f, float(i) / 256, level), offset(*d, 1, 0.0f, float(i) / 256, level)) << i;
}

TEST_F(Displacing, SeamsOfAnAtlasAreClosed) {
  Cage cage = mixedCage(); // every face is a separate square: all edges are seams
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned i = 0; i < cage.faceSizes[face]; i++) {
      const float angle = 6.2832f * float(i) / float(cage.faceSizes[face]);
      cage.uvIndices.push_back(unsigned(cage.uvs.size()));
      cage.uvs.push_back({0.1f * float(face) + 0.04f * std::cos(angle), 0.5f + 0.3f * std::sin(angle)});
    }
  const auto d = displaced(cage, path(ramp(64)), 2.0f);
  for (int level : {1, 3, 6}) expectClosed(cage, *d, level);
}

TEST_F(Displacing, OneMapOnEveryFaceIsClosed) {
  const Cage cage = mixedCage();
  const auto d = displaced(cage, path(ramp(32)), 2.0f);
  const std::string map = path(ramp(32));
  EXPECT_TRUE(containsInOrder(warningsOf(cage, map), {map, "border"}));
  for (int level : {1, 3, 6}) expectClosed(cage, *d, level);
  EXPECT_EQ(warningsOf(cage, path(flat(8, 0.25f))), "");
}

TEST_F(Displacing, ImagePerFaceIsReadAndClosed) {
  const Cage cage = mixedCage();
  std::vector<HeightMap> maps; // 5 for the pentagon, 3 for the triangle
  for (int i = 0; i < 14; i++) maps.push_back(flat(8, float(i)));
  EXPECT_EQ(warningsOf(cage, pages(maps)), "");
  const auto d = displaced(cage, pages(maps), 1.0f);
  EXPECT_EQ(offset(*d, 0, 2.0f * 3 + 0.5f + 0.4f, 0.7f), 3.0f - neutralHeight) << "fourth corner of the pentagon";
  EXPECT_EQ(offset(*d, 2, 0.5f, 0.5f), 6.0f - neutralHeight);
  EXPECT_EQ(offset(*d, 7, 0.5f, 0.5f), 13.0f - neutralHeight);
  expectClosed(cage, *d, 4);
  maps.pop_back();
  EXPECT_THROW(displaced(cage, pages(maps), 1.0f), Error);
}

/* An image of some channels, with the same value in all texels. */
std::string constantImage(const std::filesystem::path& file, const std::vector<float>& color, OIIO::TypeDesc type) {
  const auto output = OIIO::ImageOutput::create(file.string());
  OIIO::ImageSpec spec(8, 8, int(color.size()), type);
  std::vector<float> texels;
  for (int i = 0; i < 64; i++) texels.insert(texels.end(), color.begin(), color.end());
  spec.attribute("oiio:UnassociatedAlpha", 1); // unassociated alpha: colors are not multiplied
  EXPECT_TRUE(output->open(file.string(), spec) && output->write_image(OIIO::TypeDesc::FLOAT, texels.data()) &&
              output->close());
  return file.string();
}

/* The two quads, the right one on the next tile. */
Cage quadsOnTiles() {
  Cage cage = twoQuads();
  cage.uvs = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {2, 1}};
  return cage;
}

TEST_F(Displacing, UdimTileIsChosenByTheCenterOfAFace) {
  const Cage cage = quadsOnTiles();
  path(flat(8, 0.75f), "skin.1001.exr");
  path(flat(8, 1.5f), "skin.1002.exr");
  const std::string skin = (folder / "skin.<UDIM>.exr").string();
  EXPECT_EQ(warningsOf(cage, skin), "");
  const auto d = displaced(cage, skin, 1.0f);
  EXPECT_FLOAT_EQ(offset(*d, 0, 0.5f, 0.5f), 0.25f);
  EXPECT_FLOAT_EQ(offset(*d, 0, 0.999f, 0.5f), 0.25f) << "includes the border of the tile";
  EXPECT_FLOAT_EQ(offset(*d, 1, 0.5f, 0.5f), 1.0f);
  for (int i = 0; i <= 16; i++) // on the common border
  {
    EXPECT_FLOAT_EQ(offset(*d, 0, 1.0f, float(i) / 16), 0.625f) << i;
    EXPECT_EQ(offset(*d, 0, 1.0f, float(i) / 16), offset(*d, 1, 0.0f, float(i) / 16)) << i;
  }
}

TEST_F(Displacing, UdimTilesCanBeNamedInSeveralWays) {
  const std::pair<const char*, std::pair<const char*, const char*>> spellings[] = {
      {"skin.<UDIM>.exr", {"skin.1001.exr", "skin.1002.exr"}},
      {"skin.<udim>.exr", {"skin.1001.exr", "skin.1002.exr"}},
      {"skin.%(UDIM)d.exr", {"skin.1001.exr", "skin.1002.exr"}},
      {"skin_<UVTILE>.exr", {"skin_u1_v1.exr", "skin_u2_v1.exr"}},
      {"skin_<uvtile>.exr", {"skin_u0_v0.exr", "skin_u1_v0.exr"}},
      {"<U>_<V>.exr", {"u1_v1.exr", "u2_v1.exr"}},
      {"<u>_<v>.exr", {"u0_v0.exr", "u1_v0.exr"}},
      {"<UDIM>_<UDIM>.exr", {"1001_1001.exr", "1002_1002.exr"}}};
  for (const auto& [spelling, files] : spellings) {
    SCOPED_TRACE(spelling);
    path(flat(8, 0.75f), files.first);
    path(flat(8, 1.5f), files.second);
    const std::string map = (folder / spelling).string();
    EXPECT_EQ(warningsOf(quadsOnTiles(), map), "");
    const auto d = displaced(quadsOnTiles(), map, 1.0f);
    EXPECT_FLOAT_EQ(offset(*d, 0, 0.5f, 0.5f), 0.25f);
    EXPECT_FLOAT_EQ(offset(*d, 1, 0.5f, 0.5f), 1.0f);
    std::filesystem::remove(folder / files.first);
    std::filesystem::remove(folder / files.second);
    EXPECT_THROW(displaced(quadsOnTiles(), map, 1.0f), Error);
  }
}

TEST_F(Displacing, TextureCoordinatesOnSomeFacesOnlyAreAnError) {
  std::istringstream stream("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\nf 1 3 4\nf 1 2 4\n");
  std::string warnings;
  const Cage cage = readObj(stream, "body.obj", warnings);
  const std::string map = path(flat(4, 0.5f));
  EXPECT_TRUE(containsInOrder(errorOf(cage, map), {"body.obj:7: ", "texture coordinates", map, " 2 ", " 3 "}));
}

TEST_F(Displacing, MissingTexelsDoNotDisplace) {
  const std::string file = constantImage(folder / "missing.exr", {NAN, 0.2f, -0.3f}, OIIO::TypeDesc::FLOAT);
  DisplacementMap map;
  map.path = file;
  map.scale = 2.0f;
  map.midLevel = 0.125f;
  std::string warnings;
  EXPECT_EQ(offset(*displaceByMap(twoQuads(), map, warnings), 0, 0.5f, 0.5f), 0.0f);
  map.channel = "G";
  EXPECT_FLOAT_EQ(offset(*displaceByMap(twoQuads(), map, warnings), 0, 0.5f, 0.5f), 0.15f);
  EXPECT_TRUE(containsInOrder(warnings, {file, " 64 texels"}));
  EXPECT_EQ(warnings.find('\n'), warnings.size() - 1) << warnings;
  map.channel.clear();
  map.values = MapValues::ObjectVectors;
  const float u = 0.4f, v = 0.7f;
  const Vec3f normal{0, 0, 1};
  Vec3f moved{1, 1, 1};
  displaceByMap(twoQuads(), map, warnings)->vectors({0, finestLevel, 1, &u, &v}, &normal, &moved);
  EXPECT_EQ(length(moved), 0.0f) << "a vector with a missing channel";
}

TEST_F(Displacing, FacesWithoutAUdimTileAreNotDisplaced) {
  path(flat(8, 0.75f), "skin.1001.exr");
  const std::string skin = (folder / "skin.<UDIM>.exr").string();
  EXPECT_TRUE(containsInOrder(warningsOf(quadsOnTiles(), skin), {skin, "1002", "1 face", "two"}));
  EXPECT_FLOAT_EQ(offset(*displaced(quadsOnTiles(), skin, 1.0f), 1, 0.5f, 0.5f), 0.0f);
  const std::string hide = (folder / "hide.<UDIM>.exr").string();
  EXPECT_TRUE(containsInOrder(errorOf(quadsOnTiles(), hide), {hide, "two", "1002"}));
  for (const Vec2f& move : {Vec2f{0, -1}, Vec2f{-5, 0}}) {
    Cage outside = quadsOnTiles();
    for (Vec2f& uv : outside.uvs) uv = {uv.x + move.x, uv.y + move.y};
    EXPECT_TRUE(containsInOrder(errorOf(outside, skin), {skin, "two", "outside", " 0 ", " 10 "}));
  }
  EXPECT_THROW(displaced(withoutUVs(quadsOnTiles()), skin, 1.0f), Error);
}

TEST_F(Displacing, MissingTilesAreNamedWithTheSpellingThatExists) {
  const auto errorFor = [&](const std::string& name) { return errorOf(quadsOnTiles(), (folder / name).string()); };
  const auto in = [&](const std::string& name) { return (folder / name).string(); };
  EXPECT_TRUE(
      containsInOrder(errorFor("skin_<uvtile>.exr"), {in("skin_<uvtile>.exr"), "1002", in("skin_u1_v0.exr"),
                                                      "<UDIM> is 1002", "<UVTILE> is u2_v1", "<uvtile> is u1_v0"}));
  EXPECT_TRUE(containsInOrder(errorFor("skin_u<U>_v<V>.exr"), {"1002", in("skin_uu2_vv1.exr")}));
  const std::pair<const char*, std::vector<std::pair<const char*, const char*>>> existing[] = {
      {"skin_u2_v1.exr",
       {{"skin_<uvtile>.exr", "skin_<UVTILE>.exr"},
        {"skin_<UDIM>.exr", "skin_<UVTILE>.exr"},
        {"skin_u<U>_v<V>.exr", "skin_<U>_<V>.exr"},
        {"skin_<u>_<v>.exr", "skin_<UVTILE>.exr"}}},
      {"skin_u1_v0.exr", {{"skin_<UVTILE>.exr", "skin_<uvtile>.exr"}, {"skin_u<u>_v<v>.exr", "skin_<u>_<v>.exr"}}},
      {"skin_1002.exr", {{"skin_<UVTILE>.exr", "skin_<UDIM>.exr"}, {"skin_<uvtile>.exr", "skin_<UDIM>.exr"}}}};
  for (const auto& [file, spellings] : existing) {
    path(flat(8, 0.75f), file);
    for (const auto& [given, expected] : spellings)
      EXPECT_TRUE(containsInOrder(errorFor(given), {in(given), "1002", in(file) + " exists", in(expected)})) << given;
    std::filesystem::remove(folder / file);
  }
  path(flat(8, 0.75f), "skin_u1_v1.exr"); // tile 1001 from 1, tile 1012 from 0
  path(flat(8, 0.75f), "skin_u1_v0.exr");
  EXPECT_TRUE(containsInOrder(
      warningsOf(quadsOnTiles(), in("skin_<uvtile>.exr")),
      {"1001", in("skin_u0_v0.exr"), "1 face", in("skin_u1_v1.exr") + " exists", in("skin_<UVTILE>.exr")}));
}

TEST_F(Displacing, FileWithAPlaceholderInItsNameIsOneMap) {
  const std::string skin = path(flat(8, 0.75f), "skin_<UDIM>.exr");
  path(flat(8, 1.5f), "skin_1002.exr");
  const auto d = displaced(quadsOnTiles(), skin, 1.0f);
  for (unsigned face = 0; face < 2; face++) EXPECT_FLOAT_EQ(offset(*d, face, 0.5f, 0.5f), 0.25f);
  EXPECT_EQ(offset(*displaced(withoutUVs(quadsOnTiles()), skin, 1.0f), 1, 0.5f, 0.5f), 0.25f);
}

TEST_F(Displacing, OnlyTheFirstOfSeveralImagesIsReadByTextureCoordinates) {
  const std::string maps = pages({flat(8, 0.75f), flat(8, 1.5f)});
  EXPECT_TRUE(containsInOrder(warningsOf(twoQuads(), maps), {maps, " 2 images", "two", "first", "PART.CHANNEL"}));
  EXPECT_EQ(warningsOf(withoutUVs(twoQuads()), maps), "");
}

TEST_F(Displacing, SuspiciousCoordinatesAndMapsCauseWarnings) {
  const std::string map = path(flat(8, 0.75f));
  EXPECT_TRUE(containsInOrder(warningsOf(quadsOnTiles(), map), {"two", " 1001 ", " 1002", map, "<UDIM>"}));
  EXPECT_EQ(warningsOf(twoQuads(), map), "");
  const std::string normals = constantImage(folder / "normals.png", {0.5f, 0.55f, 0.99f}, OIIO::TypeDesc::UINT8);
  EXPECT_TRUE(containsInOrder(warningsOf(twoQuads(), normals), {normals, "normal map"}));
  const std::string gray = constantImage(folder / "gray.png", {0.7f, 0.7f, 0.7f}, OIIO::TypeDesc::UINT8);
  EXPECT_EQ(warningsOf(twoQuads(), gray), "");
}

TEST_F(Displacing, MidLevelAndChannelAreApplied) {
  DisplacementMap map;
  map.path = constantImage(folder / "color.exr", {0.1f, 0.2f, 0.4f}, OIIO::TypeDesc::FLOAT);
  map.scale = 2.0f;
  std::string warnings;
  const auto here = [&] { return offset(*displaceByMap(twoQuads(), map, warnings), 0, 0.5f, 0.5f); };
  EXPECT_FLOAT_EQ(here(), 2.0f * (0.1f - 0.5f));
  map.midLevel = 0.0f;
  for (const auto& [channel, value] :
       {std::pair<const char*, float>{"G", 0.2f}, {"B", 0.4f}, {"1", 0.2f}, {"0", 0.1f}}) {
    map.channel = channel;
    EXPECT_FLOAT_EQ(here(), 2.0f * value) << channel;
  }
  for (const char* channel : {"A", "3", "-1", "2147483647", "green"}) {
    map.channel = channel;
    EXPECT_THROW(here(), Error) << channel;
  }
}

TEST_F(Displacing, AlphaIsNotMultipliedIn) {
  const std::string map = constantImage(folder / "alpha.png", {0.8f, 0.8f, 0.8f, 0.25f}, OIIO::TypeDesc::UINT16);
  EXPECT_NEAR(offset(*displaced(twoQuads(), map, 1.0f), 0, 0.5f, 0.5f), 0.8f - neutralHeight, 1e-4f);
}

TEST_F(Displacing, RepeatedMapsWrapAround) {
  DisplacementMap map;
  map.path = path(ramp(64));
  std::string warnings;
  const Cage cage = twoQuads(), bare = withoutUVs(cage);
  const auto once = displaceByMap(bare, map, warnings);
  map.repeat = {4, 2};
  const auto often = displaceByMap(bare, map, warnings);
  EXPECT_NEAR(offset(*often, 0, 0.1f, 0.2f), offset(*once, 0, 0.4f, 0.4f), 1e-5f);
  EXPECT_NEAR(offset(*often, 0, 0.35f, 0.7f), offset(*often, 0, 0.1f, 0.2f), 1e-5f);
  Cage scaled = cage;
  for (Vec2f& uv : scaled.uvs) uv = {4 * uv.x, 2 * uv.y};
  const auto byCoordinates = displaceByMap(cage, map, warnings);
  map.repeat = {1, 1};
  EXPECT_EQ(offset(*byCoordinates, 0, 0.3f, 0.6f, 5), offset(*displaceByMap(scaled, map, warnings), 0, 0.3f, 0.6f, 5));
}

Vec3f vectorAt(const Displacement& d, unsigned face, float u, float v, Vec3f normal) {
  Vec3f result;
  d.vectors({face, finestLevel, 1, &u, &v}, &normal, &result);
  return result;
}

void expectVector(Vec3f found, Vec3f expected) {
  EXPECT_NEAR(length(found - expected), 0.0f, 1e-5f) << found.x << ", " << found.y << ", " << found.z;
}

TEST_F(Displacing, VectorsAreInTheFrameOfTheCageOrOfItsTexture) {
  DisplacementMap map;
  map.path = constantImage(folder / "vectors.exr", {0.1f, 0.2f, -0.3f}, OIIO::TypeDesc::FLOAT);
  map.scale = 2.0f;
  map.values = MapValues::ObjectVectors;
  std::string warnings;
  Cage cage = twoQuads();
  const Vec3f up{0, 0, 1};
  const auto object = displaceByMap(cage, map, warnings);
  EXPECT_FALSE(object->isAlongNormals());
  expectVector(vectorAt(*object, 0, 0.4f, 0.7f, up), {0.2f, 0.4f, -0.6f});

  map.values = MapValues::TangentVectors; // tangent, normal, second axis
  cage.uvs = {{0, 0}, {0.5f, 0}, {1, 0}, {0, 1}, {0.5f, 1}, {1, 1}};
  expectVector(vectorAt(*displaceByMap(cage, map, warnings), 0, 0.4f, 0.7f, up), {0.2f, -0.6f, 0.4f});
  Cage turnedCage = cage; // texture coordinates rotated by 90 degrees: u along y, v along -x
  for (Vec2f& uv : turnedCage.uvs) uv = {uv.y, 1 - uv.x};
  expectVector(vectorAt(*displaceByMap(turnedCage, map, warnings), 1, 0.4f, 0.7f, up), {0.6f, 0.2f, 0.4f});
  Cage mirrored = cage; // u along -x
  for (Vec2f& uv : mirrored.uvs) uv = {1 - uv.x, uv.y};
  expectVector(vectorAt(*displaceByMap(mirrored, map, warnings), 0, 0.4f, 0.7f, up), {-0.2f, -0.6f, 0.4f});
  EXPECT_THROW(displaceByMap(withoutUVs(cage), map, warnings), Error);
  map.channel = "1";
  EXPECT_THROW(displaceByMap(cage, map, warnings), Error) << "two channels are not enough";
}

TEST_F(Displacing, VectorsAreClosedOnSeams) {
  Cage cage = mixedCage();
  for (unsigned face = 0; face < cage.numFaces(); face++) // every face is a separate square, some of them mirrored
    for (unsigned i = 0; i < cage.faceSizes[face]; i++) {
      const float angle = (face % 2 ? 6.2832f : -6.2832f) * float(i) / float(cage.faceSizes[face]);
      cage.uvIndices.push_back(unsigned(cage.uvs.size()));
      cage.uvs.push_back({0.1f * float(face) + 0.04f * std::cos(angle), 0.5f + 0.3f * std::sin(angle)});
    }
  DisplacementMap map;
  map.path = constantImage(folder / "vectors.exr", {0.1f, 0.2f, -0.3f}, OIIO::TypeDesc::FLOAT);
  map.values = MapValues::TangentVectors;
  std::string warnings;
  const auto d = displaceByMap(cage, map, warnings);
  const FaceBorders borders(cage);
  const Vec3f normal = normalize(Vec3f{0.3f, 0.5f, 0.8f});
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned edge = 0; edge < cage.faceSizes[face]; edge++)
      for (float t : {0.0f, 0.25f, 0.5f, 1.0f}) {
        const FaceBorders::Side other = borders.opposite(face, edge);
        const FacePoint a = borders.point(face, edge, t), b = borders.point(other.face, other.edge, 1 - t);
        const Vec3f x = vectorAt(*d, a.face, a.u, a.v, normal), y = vectorAt(*d, b.face, b.u, b.v, normal);
        EXPECT_TRUE(x.x == y.x && x.y == y.y && x.z == y.z) << "face " << face << " edge " << edge << " at " << t;
      }
}

/* Three quads at one edge; two of them traverse it in the same direction. */
TEST_F(Displacing, EdgesOfThreeFacesAreClosed) {
  Cage cage;
  cage.name = "fin";
  cage.positions = {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}, {-1, 1, 0}, {-1, 0, 0}, {0, 1, 1}, {0, 0, 1}};
  cage.faceSizes = {4, 4, 4};
  cage.faceIndices = {0, 3, 2, 1, 0, 1, 4, 5, 0, 1, 6, 7};
  const auto d = displaced(cage, path(ramp(32)), 2.0f);
  for (int i = 0; i <= 8; i++) {
    const float t = float(i) / 8;
    const float expected = offset(*d, 1, t, 0.0f, 3);
    EXPECT_EQ(offset(*d, 2, t, 0.0f, 3), expected) << t;
    EXPECT_EQ(offset(*d, 0, 0.0f, t, 3), expected) << t;
  }
}

TEST_F(Displacing, MapsAreFilteredToTheSpacing) {
  HeightMap checker(256, 256); // too fine for coarse levels, which must sample its mean
  for (int y = 0; y < 256; y++)
    for (int x = 0; x < 256; x++) checker.at(x, y) = float((x + y) & 1);
  Cage cage = twoQuads();
  cage.uvs = {{0, 0}, {0.5f, 0}, {1, 0}, {0, 1}, {0.5f, 1}, {1, 1}};
  const std::string file = path(checker);
  const auto byUVs = displaced(cage, file, 1.0f), byFace = displaced(withoutUVs(cage), file, 1.0f);
  const float texel = 100.5f / 256.0f;
  for (const Displacement* d : {byUVs.get(), byFace.get()}) {
    EXPECT_NEAR(offset(*d, 0, texel, texel, 3), 0.0f, 0.02f);
    EXPECT_GT(std::abs(offset(*d, 0, d == byUVs.get() ? 2 * texel - 0.4f : texel, texel, 9)), 0.05f);
  }
}

TEST_F(Displacing, IsIndependentOfThreadsAndOrder) {
  const Cage cage = twoQuads();
  const std::string file = path(ramp(512));
  const auto alone = displaced(cage, file, 1.0f), shared = displaced(cage, file, 1.0f);
  constexpr size_t n = 20000;
  std::vector<float> expected(n), got(n);
  const auto point = [](size_t i) { return Vec2f{float(i * 7919 % 4096) / 4096, float(i * 104729 % 4096) / 4096}; };
  for (size_t i = 0; i < n; i++) expected[i] = offset(*alone, i & 1, point(i).x, point(i).y, 6);
  parallelFor(n, 16, 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++)
      got[n - 1 - i] = offset(*shared, (n - 1 - i) & 1, point(n - 1 - i).x, point(n - 1 - i).y, 6);
  });
  EXPECT_EQ(expected, got);
}

TEST_F(Displacing, NeutralHeightMovesNothing) {
  const std::string map = path(flat(4, neutralHeight));
  const Cage cage = twoQuads();
  EXPECT_EQ(offset(*displaced(cage, map, 3.0f), 1, 0.3f, 0.7f), 0.0f);
  EXPECT_EQ(offset(*displaced(withoutUVs(cage), map, 3.0f), 1, 0.3f, 0.7f), 0.0f);
  EXPECT_EQ(offset(*displaceByAtlas(cage, FaceAtlas::forFaces(2, 2), flat(6, neutralHeight), 3.0f), 0, 0.3f, 0.7f),
            0.0f);
}

TEST_F(Displacing, PolygonsInterpolateOverTheirCornerQuads) {
  /* Height = s: the result is the first texture coordinate. */
  Cage triangle;
  triangle.name = "triangle";
  triangle.positions.resize(3);
  triangle.faceSizes = {3};
  triangle.faceIndices = {0, 1, 2};
  triangle.uvs = {{0.2f, 0.5f}, {0.8f, 0.5f}, {0.5f, 0.5f}};
  triangle.uvIndices = {0, 1, 2};
  HeightMap map(128, 16);
  for (int y = 0; y < 16; y++)
    for (int x = 0; x < 128; x++) map.at(x, y) = (float(x) + 0.5f) / 128.0f + neutralHeight;
  const auto d = displaced(triangle, path(map), 1.0f);
  EXPECT_NEAR(offset(*d, 0, 0.5f, 0.5f), 0.2f, 1e-5f); // corner 0
  EXPECT_NEAR(offset(*d, 0, 1.5f, 0.5f), 0.5f, 1e-5f); // center of its edge
  EXPECT_NEAR(offset(*d, 0, 2.5f, 0.5f), 0.8f, 1e-5f); // corner 1
  EXPECT_NEAR(offset(*d, 0, 1.5f, 1.5f), 0.5f, 1e-5f); // center of the face, from corner 0
  EXPECT_NEAR(offset(*d, 0, 3.5f, 1.5f), 0.5f, 1e-5f); // the same from corner 1
}

TEST(FaceAtlas, TilesAgreeOnBordersAtEveryLevel) {
  const Cage cube = makeCube().cage;
  const FaceAtlas atlas = FaceAtlas::forFaces(cube.numFaces(), 16);
  HeightMap map(atlas.columns(), atlas.rows(cube.numFaces()));
  for (int y = 0; y < map.height(); y++)
    for (int x = 0; x < map.width(); x++) map.at(x, y) = std::sin(0.37f * float(x * x) + 1.7f * float(y));
  const auto d = displaceByAtlas(cube, atlas, map, 1.0f);
  for (int level : {0, 1, 2, 3}) // the tiles themselves disagree; coarser levels are made consistent
    expectClosed(cube, *d, level);
}

TEST(FaceAtlas, TilesAreExactAtTheirTexels) {
  const FaceAtlas atlas = FaceAtlas::forFaces(7, 8);
  Cage cage;
  for (unsigned i = 0; i < 7; i++) {
    cage.faceSizes.push_back(4);
    for (unsigned j = 0; j < 4; j++) cage.faceIndices.push_back(4 * i + j);
  }
  cage.positions.resize(28);
  HeightMap map(atlas.columns(), atlas.rows(7));
  for (int y = 0; y < map.height(); y++)
    for (int x = 0; x < map.width(); x++) map.at(x, y) = float(y * map.width() + x);
  const auto d = displaceByAtlas(cage, atlas, map, 1.0f);
  for (int face = 0; face < 7; face++)
    for (int y = 0; y <= 8; y++)
      for (int x = 0; x <= 8; x++) {
        const int column = face % atlas.tilesPerRow * 9 + x, row = face / atlas.tilesPerRow * 9 + y;
        EXPECT_EQ(offset(*d, unsigned(face), float(x) / 8, float(y) / 8), map.at(column, row) - neutralHeight);
      }
}

TEST(Displacement, CubeSpikesVanishOnTheBorders) {
  const Model cube = makeCube();
  for (int i = 0; i <= 64; i++)
    for (auto [u, v] : {std::pair<float, float>{0, i / 64.0f}, {1, i / 64.0f}, {i / 64.0f, 0}, {i / 64.0f, 1}})
      EXPECT_NEAR(offset(*cube.displacement, 2, u, v), 0.0f, 1e-12f);
  EXPECT_NEAR(offset(*cube.displacement, 2, 0.5f, 0.5f), cubeAmplitude * cube.cage.bounds().diagonal(), 1e-6f);
}

}} // namespace programs::test
