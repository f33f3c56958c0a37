// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Interpolation on faces without a surface. Faces with fewer than 3 or more than 16 corners, or at vertices with too
 * many faces, are errors, because Embree's patches do not support them. Holes are not. */

#include "support/message_parts.h"
#include "support/scene.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

enum class On { Vertices, Attribute, OtherTopology };

struct Values {
  float values[6][3];
  bool operator==(const Values& other) const { return std::memcmp(values, other.values, sizeof(values)) == 0; }
  bool isFinite() const {
    return std::all_of(&values[0][0], &values[0][0] + 18, [](float f) { return std::isfinite(f); });
  }
};

const float untouched = 12345;

// In a face, or in the first sub-patch of a face without four corners.
Values interpolate(RTCGeometry geometry, unsigned face, On on, float u = 0.8f, float v = 0.9f) {
  Values out;
  std::fill_n(&out.values[0][0], 18, untouched);
  RTCInterpolateArguments args = {};
  args.geometry = geometry;
  args.primID = face;
  args.u = u;
  args.v = v;
  args.bufferType = on == On::Vertices ? RTC_BUFFER_TYPE_VERTEX : RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE;
  args.bufferSlot = on == On::OtherTopology;
  args.P = out.values[0];
  args.dPdu = out.values[1];
  args.dPdv = out.values[2];
  args.ddPdudu = out.values[3];
  args.ddPdvdv = out.values[4];
  args.ddPdudv = out.values[5];
  args.valueCount = 3;
  rtcInterpolate(&args);
  return out;
}

// The same with rtcInterpolateN, in lane 2 of 4. The other lanes are inactive.
Values interpolateN(RTCGeometry geometry, unsigned face, On on, bool isActive = true, float u = 0.8f, float v = 0.9f) {
  alignas(16) int valid[4] = {0, 0, isActive ? -1 : 0, 0};
  alignas(16) unsigned faces[4] = {face, face, face, face};
  alignas(16) float us[4] = {0.8f, 0.8f, u, 0.8f}, vs[4] = {0.9f, 0.9f, v, 0.9f};
  float values[6][3][4];
  std::fill_n(&values[0][0][0], 72, untouched);
  RTCInterpolateNArguments args = {};
  args.geometry = geometry;
  args.valid = valid;
  args.primIDs = faces;
  args.u = us;
  args.v = vs;
  args.N = 4;
  args.bufferType = on == On::Vertices ? RTC_BUFFER_TYPE_VERTEX : RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE;
  args.bufferSlot = on == On::OtherTopology;
  args.P = &values[0][0][0];
  args.dPdu = &values[1][0][0];
  args.dPdv = &values[2][0][0];
  args.ddPdudu = &values[3][0][0];
  args.ddPdvdv = &values[4][0][0];
  args.ddPdudv = &values[5][0][0];
  args.valueCount = 3;
  rtcInterpolateN(&args);
  Values out;
  for (int i = 0; i < 6; i++)
    for (int k = 0; k < 3; k++) out.values[i][k] = values[i][k][2];
  return out;
}

// Vertices are also attribute 0. `others`, with their own topology, are attribute 1.
RTCGeometry newGeometry(RTCDevice device, const Cage& cage, const Cage* others,
                        RTCCompression compression = RTC_COMPRESSION_NONE, bool releases = false) {
  SurfaceSettings settings;
  settings.rate = 3;
  RTCGeometry geometry = newSurface(device, cage, settings);
  rtcSetGeometryVertexAttributeCount(geometry, others ? 2 : 1);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT3, cage.positions);
  if (others) {
    rtcSetGeometryTopologyCount(geometry, 2);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 1, RTC_FORMAT_FLOAT3, others->positions);
    setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 1, RTC_FORMAT_UINT, others->indices);
    rtcSetGeometryVertexAttributeTopology(geometry, 1, 1);
  }
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = compression;
  args.flags = releases ? RTC_COMPRESSION_FLAG_RELEASE_INPUT : RTC_COMPRESSION_FLAG_NONE;
  rtcSetGeometryCompression(geometry, &args);
  rtcCommitGeometry(geometry);
  return geometry;
}

template<typename Check>
void forEachForm(const Cage& cage, const Cage* others, const Check& check) {
  for (int form = 0; form < 3; form++) {
    SCOPED_TRACE(form == 0 ? "uncompressed" : form == 1 ? "compressed" : "released");
    Device device;
    const RTCCompression compression = form == 0 ? RTC_COMPRESSION_NONE : RTC_COMPRESSION_CVERT;
    RTCGeometry geometry = newGeometry(device, cage, others, compression, form == 2);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    std::vector<On> buffers = {On::Attribute};
    if (form != 2) buffers.push_back(On::Vertices);
    if (others) buffers.push_back(On::OtherTopology);
    for (On on : buffers) check(device, geometry, on);
    rtcReleaseGeometry(geometry);
  }
}

void expectRefused(Device& device, RTCGeometry geometry, unsigned face, On on, const std::vector<std::string>& parts) {
  SCOPED_TRACE(testing::Message() << "face " << face << ", buffer " << int(on));
  std::vector<std::string> expected = {"face " + std::to_string(face) + " "};
  expected.insert(expected.end(), parts.begin(), parts.end());
  Values none;
  std::fill_n(&none.values[0][0], 18, untouched);
  for (bool inLanes : {false, true}) {
    EXPECT_TRUE((inLanes ? interpolateN(geometry, face, on) : interpolate(geometry, face, on)) == none);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(containsInOrder(device.message, expected));
  }
  EXPECT_TRUE(interpolateN(geometry, face, on, false) == none);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << "no lane is active: " << device.message;
}

Values expectFinite(Device& device, RTCGeometry geometry, unsigned face, On on) {
  SCOPED_TRACE(testing::Message() << "face " << face << ", buffer " << int(on));
  const Values one = interpolate(geometry, face, on), lane = interpolateN(geometry, face, on);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_TRUE(one.isFinite() && lane.isFinite());
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) EXPECT_NEAR(one.values[i][k], lane.values[i][k], 1e-3f);
  return one;
}

const std::vector<std::string> outOfBounds = {" 3 ", " 16 vertices", " 1024 faces"};

TEST(Interpolation, UnsupportedFacesAreErrors) {
  const auto fan = [](unsigned quads, unsigned corners) { // around a vertex of the border: quads, and one other face
    Cage cage;
    cage.positions.push_back({0, 0, 0});
    const auto add = [&](double angle, double radius) {
      cage.positions.push_back({float(radius * std::cos(angle)), float(radius * std::sin(angle)), 0});
      return unsigned(cage.positions.size() - 1);
    };
    unsigned spoke = add(0, 1);
    for (unsigned f = 0; f <= quads; f++) {
      const unsigned size = f == quads ? corners : 4;
      cage.faces.push_back(size);
      cage.indices.insert(cage.indices.end(), {0, spoke});
      for (unsigned i = 1; i + 2 < size; i++)
        cage.indices.push_back(add((f + i / double(size - 2)) * 5 / (quads + 1), 1.1));
      cage.indices.push_back(spoke = add(5.0 * (f + 1) / (quads + 1), 1));
    }
    return cage;
  };
  struct Case {
    const char* name;
    Cage cage;
    bool isRefused;
  } cases[] = {{"15 corners", prismCage(15), false},
               {"17 corners", prismCage(17), true},
               {"40 corners", prismCage(40), true},
               {"200 corners", prismCage(200), true},
               {"64 faces", trapezohedronCage(64), false},
               {"65 faces", trapezohedronCage(65), false},
               {"1024 faces", trapezohedronCage(1024), false},
               {"1025 faces", trapezohedronCage(1025), true},
               {"Embree's longest ring", fan(62, 5), false},
               {"the longest ring", fan(1022, 5), false},
               {"a ring too long by one", fan(1022, 6), true},
               {"1025 with the border", fan(1023, 4), true}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    forEachForm(c.cage, nullptr, [&](Device& device, RTCGeometry geometry, On on) {
      const unsigned numFaces = unsigned(c.cage.faces.size());
      for (unsigned f = 0; f < numFaces; f += 1 + numFaces / 20)
        if (c.isRefused) expectRefused(device, geometry, f, on, outOfBounds);
        else expectFinite(device, geometry, f, on);
      for (unsigned f : {numFaces, RTC_INVALID_GEOMETRY_ID}) // the second is the primID of a ray that misses
        expectRefused(device, geometry, f, on, {" " + std::to_string(numFaces) + " faces"});
    });
  }
}

// A pentagon has the sub-patches 0 to 4. Embree would read past them.
TEST(Interpolation, SubPatchesThatDoNotExistAreErrors) {
  const float odd[] = {-1, -0.01f, 8, 9, 1e7f, 1e30f, -1e30f, INFINITY, -INFINITY, NAN};
  forEachForm(prismCage(5), nullptr, [&](Device& device, RTCGeometry geometry, On on) {
    const auto expectAt = [&](float u, float v, bool exists) {
      SCOPED_TRACE(testing::Message() << "u " << u << ", v " << v << ", buffer " << int(on));
      for (bool inLanes : {false, true}) {
        const Values found = inLanes ? interpolateN(geometry, 0, on, true, u, v) : interpolate(geometry, 0, on, u, v);
        EXPECT_EQ(found.isFinite() && found.values[0][0] != untouched, exists);
        EXPECT_EQ(device.takeError(), exists ? RTC_ERROR_NONE : RTC_ERROR_INVALID_ARGUMENT) << device.message;
        if (exists) continue;
        EXPECT_EQ(found.values[0][0], untouched);
        EXPECT_TRUE(containsInOrder(device.message, {"face 0 ", " 5 sub-patches"}));
      }
      interpolateN(geometry, 0, on, false, u, v);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << "no lane is active: " << device.message;
    };
    for (unsigned i = 0; i < 16; i++) expectAt(1 + 2.0f * float(i % 4), 1 + 2.0f * float(i / 4), i < 5);
    for (float x : odd) {
      expectAt(x, 1, false);
      expectAt(1, x, false);
      expectAt(x, x, false);
    }
    /* faces with four corners are extrapolated, as in Embree */
    interpolate(geometry, 2, on, -0.25f, 1.25f);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  });
}

// A face may be supported in the surface's topology, but not in an attribute's.
TEST(Interpolation, EachTopologyHasItsOwnLimits) {
  const Cage poles = trapezohedronCage(1025), single = quadCage();
  Cage loose;
  for (unsigned f = 0; f < poles.faces.size(); f++) {
    for (Vec p : single.positions) {
      p[2] = float(f);
      loose.positions.push_back(p);
    }
    loose.addFace({4 * f, 4 * f + 1, 4 * f + 2, 4 * f + 3});
  }
  forEachForm(loose, &poles, [&](Device& device, RTCGeometry geometry, On on) {
    for (unsigned f = 0; f < poles.faces.size(); f += 131)
      if (on == On::OtherTopology) expectRefused(device, geometry, f, on, outOfBounds);
      else expectFinite(device, geometry, f, on);
  });
}

// Faces with 0, 1 and 2 corners between the faces of a cube, and at its end.
TEST(Interpolation, DegenerateFacesHaveNoInfluence) {
  const Cage cube = cubeCage();
  for (const std::vector<unsigned>& few : {std::vector<unsigned>{0}, {1}, {2}, {1, 1}, {0, 1, 2, 1, 0}}) {
    Cage cage;
    cage.positions = cube.positions;
    const unsigned own = unsigned(cage.positions.size()); // two vertices that the cube does not use
    cage.positions.insert(cage.positions.end(), {{3, 0, 0}, {4, 0, 0}});
    std::vector<unsigned> sound, without;
    const auto addFew = [&](unsigned first) {
      for (unsigned corners : few) {
        without.push_back(unsigned(cage.faces.size()));
        cage.faces.push_back(corners);
        for (unsigned i = 0; i < corners; i++) cage.indices.push_back(first + i);
      }
    };
    for (unsigned f = 0; f < 6; f++) {
      addFew(own);
      sound.push_back(unsigned(cage.faces.size()));
      cage.faces.push_back(4);
      cage.indices.insert(cage.indices.end(), &cube.indices[4 * f], &cube.indices[4 * f] + 4);
    }
    addFew(own);
    cage.faces.push_back(1);
    cage.indices.push_back(0); // at a vertex of the cube
    without.push_back(unsigned(cage.faces.size() - 1));
    Device device;
    RTCGeometry alone = newGeometry(device, cube, nullptr);
    forEachForm(cage, nullptr, [&](Device& other, RTCGeometry geometry, On on) {
      for (unsigned f : without) expectRefused(other, geometry, f, on, outOfBounds);
      for (unsigned f = 0; f < 6; f++) {
        const Values expected = interpolate(alone, f, On::Vertices);
        EXPECT_TRUE(expectFinite(other, geometry, sound[f], on) == expected) << "face " << f;
      }
    });
    rtcReleaseGeometry(alone);

    SurfaceSettings settings;
    settings.rate = 8;
    for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF}) {
      SCOPED_TRACE(kindName(compression));
      settings.compression = compression;
      const SurfaceScene expected(device, cube, settings), found(device, cage, settings);
      Random random(8);
      size_t hits = 0;
      for (const RTCRayHit& ray : raysAt(random, 200)) {
        const RTCRayHit a = intersect(expected, ray), b = intersect(found, ray);
        ASSERT_EQ(a.ray.tfar, b.ray.tfar);
        ASSERT_EQ(isHit(a) ? sound[a.hit.primID] : RTC_INVALID_GEOMETRY_ID, b.hit.primID);
        hits += isHit(a);
      }
      EXPECT_GT(hits, 50u);
    }
  }
}

TEST(Interpolation, HolesMatchTheFaceAlone) {
  for (const Cage& whole : {cubeCage(), prismCage(3), prismCage(5), sheetCage(3)})
    for (unsigned hole : {0u, 3u}) {
      SCOPED_TRACE(testing::Message() << whole.faces.size() << " faces, hole " << hole);
      Cage cage = whole, alone;
      cage.holes = {hole};
      alone.positions = whole.positions;
      const unsigned* first = whole.indices.data();
      for (unsigned f = 0; f < hole; f++) first += whole.faces[f];
      alone.faces = {whole.faces[hole]};
      alone.indices.assign(first, first + whole.faces[hole]);
      Device device;
      RTCGeometry expected = newGeometry(device, alone, nullptr);
      forEachForm(cage, nullptr, [&](Device& other, RTCGeometry geometry, On on) {
        EXPECT_TRUE(expectFinite(other, geometry, hole, on) == interpolate(expected, 0, On::Vertices));
      });
      rtcReleaseGeometry(expected);
    }
}

}} // namespace programs::test
