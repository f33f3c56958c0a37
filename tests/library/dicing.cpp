// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Edge rates for a camera: cbvhDiceSurface for the surface of a geometry. */

#include "support/closed.h"
#include "support/edge_rates.h"
#include "support/message_parts.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <limits>

namespace programs::test { namespace {

const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

// Looks along -z, with 512 x 512 pixels and a field of view of 90 degrees.
CbvhDicingArguments cameraAt(float x, float y, float z) {
  CbvhDicingArguments args;
  args.position[0] = x;
  args.position[1] = y;
  args.position[2] = z;
  args.direction[2] = -1;
  args.up[1] = 1;
  args.width = args.height = 512;
  args.pixelSize = 2.0f / 512;
  return args;
}

struct Surface {
  Surface(Device& device, const Cage& cage, RTCDisplacementFunctionN displacement = nullptr)
    : device(device),
      cage(cage) {
    SurfaceSettings settings;
    geometry = newSurface(device, cage, settings);
    rtcSetGeometryDisplacementFunction(geometry, displacement);
    rtcCommitGeometry(geometry);
  }
  ~Surface() { rtcReleaseGeometry(geometry); }

  std::vector<float> rates(const CbvhDicingArguments& args) {
    diceGeometry(geometry, &args);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const float* const levels = (const float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_LEVEL, 0);
    rtcCommitGeometry(geometry);
    return std::vector<float>(levels, levels + cage.indices.size());
  }

  Device& device;
  const Cage cage;
  RTCGeometry geometry;
};

void expectPowersOfTwo(const std::vector<float>& rates) {
  for (float rate : rates) {
    EXPECT_GE(rate, 1.0f);
    EXPECT_LE(rate, 4096.0f);
    EXPECT_EQ(std::log2(rate), std::round(std::log2(rate))) << rate;
  }
}

void expectAgreement(const Cage& cage, const std::vector<float>& rates) {
  std::map<std::pair<unsigned, unsigned>, float> rateOf;
  size_t begin = 0;
  for (unsigned n : cage.faces) {
    for (unsigned i = 0; i < n; i++) {
      const unsigned a = cage.indices[begin + i], b = cage.indices[begin + (i + 1) % n];
      const float rate = rateOf.emplace(std::minmax(a, b), rates[begin + i]).first->second;
      EXPECT_EQ(rate, rates[begin + i]) << "edge " << a << ", " << b;
    }
    begin += n;
  }
}

TEST(Dicing, QuadsHaveRequestedSize) {
  Device device;
  Surface surface(device, quadCage()); // 1 x 1
  for (float height : {0.5f, 1.0f, 3.0f, 10.0f})
    for (float size : {0.5f, 1.0f, 7.0f}) {
      CbvhDicingArguments args = cameraAt(0.5f, 0.5f, height);
      args.quadSize = size;
      const std::vector<float> rates = surface.rates(args);
      expectPowersOfTwo(rates);
      const float wanted =
          1 / (height * args.pixelSize * size); // directly below the camera; quads farther away look smaller
      for (float rate : rates) {
        EXPECT_LE(rate, 1.5f * wanted) << height << ", " << size;
        EXPECT_GE(rate, wanted / 2.2f) << height << ", " << size; // corners are up to 1.73 times as far away
      }
    }
}

TEST(Dicing, NeighborsAgreeAndNearFacesAreFiner) {
  Device device;
  for (const auto& c : closedCages) {
    SCOPED_TRACE(c.name);
    Surface surface(device, c.cage);
    const std::vector<float> rates = surface.rates(cameraAt(0.3f, 0.2f, 1.3f));
    expectPowersOfTwo(rates);
    expectAgreement(c.cage, rates);
    EXPECT_LT(*std::min_element(rates.begin(), rates.end()), *std::max_element(rates.begin(), rates.end()));
    const std::vector<float> farther = surface.rates(cameraAt(0.3f, 0.2f, 20));
    for (size_t i = 0; i < rates.size(); i++) EXPECT_LT(farther[i], rates[i]);
  }
}

TEST(Dicing, SurfacesOutsideOfThePictureAreCoarserUpToABound) {
  Device device;
  Surface surface(device, quadCage());
  for (float width : {6.0f, 2.0f, 0.35f, 0.13f}) { // of the picture at distance 1
    CbvhDicingArguments all = cameraAt(0.5f, 0.5f, 2);
    all.pixelSize = width / 512;
    CbvhDicingArguments outside = all;
    all.width = all.height = 0; // no picture bounds: all directions
    const float seen = surface.rates(all)[0];
    // the surface is behind the camera, diagonally behind it, and to the right of a narrow picture
    const std::vector<Vec> directions = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 0.1f}};
    for (size_t i = 0; i < (width < 1 ? directions.size() : 4); i++) {
      SCOPED_TRACE(testing::Message() << "width " << width << ", direction " << i);
      std::copy_n(directions[i].data(), 3, outside.direction);
      outside.up[0] = 0;
      outside.up[1] = i == 2 || i == 3 ? 0 : 1;
      outside.up[2] = i == 2 || i == 3 ? 1 : 0;
      for (float factor : {1.0f, 4.0f, 16.0f}) {
        outside.outsideFactor = factor;
        EXPECT_EQ(surface.rates(outside)[0], seen / factor) << "factor " << factor;
      }
    }
  }
}

// The picture shows a small part of a face whose border is far outside of it.
TEST(Dicing, FaceIsAsFineAsItsVisiblePart) {
  Device device;
  Surface surface(device, quadCage(20));
  const CbvhDicingArguments args = cameraAt(9.3f, 8.6f, 1);
  const std::vector<float> rates = surface.rates(args);
  for (int i = 0; i < 2; i++) // of two opposite edges, the higher rate determines the quads of the face
    EXPECT_GE(std::max(rates[i], rates[i + 2]), 0.5f * std::min(4096.0f, 20 / args.pixelSize));
}

TEST(Dicing, LengthOfDisplacedSurfaceCounts) {
  Device device;
  const auto waves = [](const RTCDisplacementFunctionNArguments* args) {
    // no displacement at v = 0 and v = 1
    for (unsigned i = 0; i < args->N; i++)
      args->P_z[i] += 0.2f * std::sin(30 * args->u[i]) * std::sin(float(M_PI) * args->v[i]);
  };
  const CbvhDicingArguments args = cameraAt(0.5f, 0.5f, 4);
  Surface flat(device, quadCage()), displaced(device, quadCage(), waves);
  EXPECT_GE(displaced.rates(args)[0], 2 * flat.rates(args)[0]);
}

TEST(Dicing, MaxRateIsRespected) {
  Device device;
  Surface surface(device, cubeCage());
  CbvhDicingArguments args = cameraAt(0, 0, 3);
  std::vector<float> bounds(24, 8.0f);
  args.maxRates = bounds.data();
  for (float rate : surface.rates(args)) EXPECT_LE(rate, 8.0f);
  std::fill(bounds.begin(), bounds.end(), 3.0f); // no power of two, to which rates are rounded
  for (float rate : surface.rates(args)) EXPECT_LE(rate, 3.0f);
  const float belowEight = std::nextafter(8.0f, 0.0f); // in floats, its logarithm is 3
  std::fill(bounds.begin(), bounds.end(), belowEight);
  for (float rate : surface.rates(args)) EXPECT_LE(rate, 4.0f);
  args.maxRates = nullptr;
  args.maxRate = 13;
  for (float rate : surface.rates(args)) EXPECT_LE(rate, 8.0f);
  args.maxRate = belowEight;
  for (float rate : surface.rates(args)) EXPECT_LE(rate, 4.0f);
  args.maxRate = std::nextafter(4096.0f, 0.0f);
  args.quadSize = 1e-6f;
  for (float rate : surface.rates(args)) EXPECT_LE(rate, 2048.0f);
}

TEST(Dicing, TinyPixelsGiveTheHighestRate) {
  Device device;
  Surface surface(device, quadCage());
  for (bool orthographic : {false, true})
    for (float pixelSize : {1e-10f, 1e-20f, 1e-37f}) {
      CbvhDicingArguments args = cameraAt(0.5f, 0.5f, 2);
      args.orthographic = orthographic;
      args.pixelSize = pixelSize;
      args.maxRate = 64;
      for (float rate : surface.rates(args)) EXPECT_EQ(rate, 64) << orthographic << ", " << pixelSize;
    }
}

TEST(Dicing, OrthographicCameraIgnoresDistance) {
  Device device;
  Surface surface(device, quadCage());
  CbvhDicingArguments args = cameraAt(0.5f, 0.5f, 1);
  args.orthographic = true;
  const std::vector<float> near = surface.rates(args);
  args.position[2] = 1000;
  EXPECT_EQ(surface.rates(args), near);
  EXPECT_EQ(near, std::vector<float>(4, 256)); // pixels are 1/256 wide
}

TEST(Dicing, TransformOfInstanceIsApplied) {
  Device device;
  Surface surface(device, quadCage());
  CbvhDicingArguments args = cameraAt(0.5f, 0.5f, 2);
  const std::vector<float> here = surface.rates(args);
  const float moved[12] = {0, 3, 0, -3, 0, 0, 0, 0, 3, 10, 20, 30}; // rotated and scaled by three
  args.transform = moved;
  args.position[0] = 10 - 1.5f;
  args.position[1] = 20 + 1.5f;
  args.position[2] = 30 + 6;
  EXPECT_EQ(surface.rates(args), here);
}

TEST(Dicing, RatesAreValidOnTheSurfaceAndForNonFiniteVertices) {
  Device device;
  Surface cube(device, cubeCage());
  for (float z : {0.0f, 0.5f, 0.7f, 0.8f, 1.0f}) expectPowersOfTwo(cube.rates(cameraAt(0, 0, z)));
  for (float bad : {nan, inf, 1e30f}) {
    Cage cage = cubeCage();
    cage.positions[3][1] = bad;
    Surface surface(device, cage);
    const std::vector<float> rates = surface.rates(cameraAt(0, 0, 3));
    expectPowersOfTwo(rates);
    expectAgreement(cage, rates);
  }
}

TEST(Dicing, ClosedSurfacesStayClosed) {
  Device device("subdiv_accel=cbvh.vert");
  for (const auto& c : closedCages) {
    SCOPED_TRACE(c.name);
    Surface surface(device, c.cage);
    CbvhDicingArguments args = cameraAt(0.4f, 0.3f, 1.2f);
    args.pixelSize = 0.02f;
    surface.rates(args);
    const Scene scene(device);
    rtcAttachGeometry(scene, surface.geometry);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    Random random(71);
    std::vector<RTCRayHit> rays;
    for (int i = 0; i < 20000; i++) {
      const unsigned a = random.below(unsigned(c.cage.indices.size())),
                     b = random.below(unsigned(c.cage.indices.size()));
      RTCRayHit ray = rayFromMiddle(random, c.cage.positions[c.cage.indices[a]], c.cage.positions[c.cage.indices[b]]);
      ray.ray.org_x *= 0.1f; // prisms of triangles are slim
      ray.ray.org_y *= 0.1f;
      ray.ray.org_z *= 0.1f;
      rays.push_back(ray);
    }
    expectNoneMisses(scene, rays);
  }
}

// The common scale of model and camera, and the length of directions.
TEST(Dicing, RatesDoNotDependOnTheScale) {
  Device device;
  const auto ratesAt = [&](float scale, float length, bool orthographic) {
    Cage cage = prismCage(5);
    for (Vec& p : cage.positions)
      for (float& x : p) x *= scale;
    CbvhDicingArguments args = cameraAt(0.3f * scale, 0.2f * scale, 3 * scale);
    args.direction[2] = -length;
    for (float& x : args.up) x *= length;
    args.orthographic = orthographic;
    if (orthographic) args.pixelSize *= scale;
    return Surface(device, cage).rates(args);
  };
  for (bool orthographic : {false, true}) {
    const std::vector<float> rates = ratesAt(1, 1, orthographic);
    EXPECT_GT(*std::max_element(rates.begin(), rates.end()), 8.0f);
    for (int exponent : {-60, -40, -20, 20, 40, 59}) { // above 1.8e18 Embree considers coordinates not finite
      EXPECT_EQ(ratesAt(std::ldexp(1.0f, exponent), 1, orthographic), rates) << "scaled by 2^" << exponent;
      EXPECT_EQ(ratesAt(1, std::ldexp(1.0f, exponent), orthographic), rates) << "directions of length 2^" << exponent;
    }
    EXPECT_EQ(ratesAt(1, 1e-20f, orthographic), rates);
    EXPECT_EQ(ratesAt(1, 1e20f, orthographic), rates);
  }
}

TEST(Dicing, ZerosSelectDefaults) {
  Device device;
  Surface surface(device, quadCage(20));
  const CbvhDicingArguments zeros = cameraAt(9.3f, 8.6f, 1);
  CbvhDicingArguments defaults = zeros, others = zeros;
  defaults.quadSize = 1;
  defaults.outsideFactor = 8;
  defaults.maxRate = 4096;
  others.quadSize = 2;
  EXPECT_EQ(surface.rates(zeros), surface.rates(defaults));
  EXPECT_NE(surface.rates(zeros), surface.rates(others));
}

TEST(Dicing, InvalidArgumentsAreRejectedByName) {
  Device device;
  Surface surface(device, quadCage());
  const auto expectInvalid = [&](const std::vector<std::string>& parts,
                                 const std::function<void(CbvhDicingArguments&)>& change) {
    CbvhDicingArguments args = cameraAt(0, 0, 1);
    change(args);
    diceGeometry(surface.geometry, &args);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << parts[0];
    EXPECT_TRUE(containsInOrder(device.message, parts));
    EXPECT_EQ(rtcGetGeometryBufferData(surface.geometry, RTC_BUFFER_TYPE_LEVEL, 0), nullptr) << parts[0];
  };
  expectInvalid({"pixelSize"}, [](CbvhDicingArguments& a) { a.pixelSize = 0; });
  for (float bad : {-1.0f, nan, inf}) {
    expectInvalid({"pixelSize"}, [=](CbvhDicingArguments& a) { a.pixelSize = bad; });
    expectInvalid({"quadSize"}, [=](CbvhDicingArguments& a) { a.quadSize = bad; });
    expectInvalid({"outsideFactor"}, [=](CbvhDicingArguments& a) { a.outsideFactor = bad; });
    expectInvalid({"maxRate"}, [=](CbvhDicingArguments& a) { a.maxRate = bad; });
  }
  expectInvalid({"maxRate"}, [](CbvhDicingArguments& a) { a.maxRate = 4097; });
  for (float bad : {nan, inf}) {
    expectInvalid({"position"}, [=](CbvhDicingArguments& a) { a.position[1] = bad; });
    expectInvalid({"direction"}, [=](CbvhDicingArguments& a) { a.direction[1] = bad; });
    expectInvalid({"up"}, [=](CbvhDicingArguments& a) { a.up[1] = bad; });
    const std::vector<float> transform(12, bad);
    expectInvalid({"transform"}, [&](CbvhDicingArguments& a) { a.transform = transform.data(); });
  }
  expectInvalid({"up"}, [](CbvhDicingArguments& a) {
    a.up[1] = 0;
    a.up[2] = 5;
  });
  expectInvalid({"width"}, [](CbvhDicingArguments& a) { a.width = -1; });
  const std::vector<float> bounds = {1, 2, nan, 4};
  expectInvalid({"maxRates"}, [&](CbvhDicingArguments& a) { a.maxRates = bounds.data(); });
  const std::vector<float> justBelow = {1, 2, 0.99999994f, 4};
  expectInvalid({"maxRates", "0.99999994", " 2"}, [&](CbvhDicingArguments& a) { a.maxRates = justBelow.data(); });
  expectInvalid({"pixelSize", "-1e-20"}, [](CbvhDicingArguments& a) { a.pixelSize = -1e-20f; });

  diceGeometry(surface.geometry, nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  const CbvhDicingArguments args = cameraAt(0, 0, 1);
  RTCGeometry other = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  diceGeometry(other, &args);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  rtcReleaseGeometry(other);
  rtcUpdateGeometryBuffer(surface.geometry, RTC_BUFFER_TYPE_VERTEX, 0); // not committed after this change
  diceGeometry(surface.geometry, &args);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
}

TEST(Dicing, GeometriesWithoutCageAreRejected) {
  Device device;
  const Folder folder;
  const CbvhDicingArguments args = cameraAt(0, 0, 5);
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CVERT;
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  RTCCompressionArguments compression;
  rtcInitCompressionArguments(&compression);
  compression.compression = RTC_COMPRESSION_CVERT;
  compression.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
  rtcSetGeometryCompression(geometry, &compression);
  rtcCommitGeometry(geometry);
  ASSERT_TRUE(saveGeometryFile(geometry, (folder / "cage").c_str())) << device.message;
  RTCGeometry loaded = loadGeometryFile(device, (folder / "cage").c_str());
  ASSERT_NE(loaded, nullptr) << device.message;
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE);
  for (RTCGeometry without : {geometry, loaded}) {
    SCOPED_TRACE(without == loaded ? "loaded" : "released");
    diceGeometry(without, &args);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION) << device.message;
    EXPECT_NE(device.message.find(without == loaded ? "loaded" : "released"), std::string::npos) << device.message;
    for (unsigned id : {0u, 5u, 23u, 24u, ~0u}) {
      rtcGetGeometryFace(without, id);
      EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
      rtcGetGeometryFirstHalfEdge(without, id);
      EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
      rtcGetGeometryNextHalfEdge(without, id);
      EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
      rtcGetGeometryPreviousHalfEdge(without, id);
      EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
      rtcGetGeometryOppositeHalfEdge(without, 0, id);
      EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
    }
    rtcReleaseGeometry(without);
  }
}

// Commits leave out such faces and store the others, which must get the same rates as without them.
TEST(Dicing, UnsupportedFacesAreIgnored) {
  Device device;
  const CbvhDicingArguments args = cameraAt(0.5f, 0.5f, 2);
  const std::vector<float> alone = Surface(device, quadCage()).rates(args);
  for (const Cage& other : {prismCage(20), trapezohedronCage(1025)}) {
    SCOPED_TRACE(testing::Message() << other.faces[0] << " corners");
    Cage cage = quadCage();
    const unsigned first = unsigned(cage.positions.size());
    for (const Vec& p : other.positions) cage.positions.push_back({p[0] + 5, p[1], p[2]});
    for (unsigned vertex : other.indices) cage.indices.push_back(first + vertex);
    cage.faces.insert(cage.faces.end(), other.faces.begin(), other.faces.end());
    const std::vector<float> rates = Surface(device, cage).rates(args);
    for (size_t i = 0; i < rates.size(); i++) EXPECT_EQ(rates[i], i < alone.size() ? alone[i] : 1.0f) << i;
  }
}

TEST(Dicing, CagesWithInvalidIndicesAreRejected) {
  Device device;
  Cage cage = cubeCage();
  cage.indices[13] = 1000;
  RTCGeometry geometry = newSurface(device, cage, SurfaceSettings());
  rtcCommitGeometry(geometry);
  device.takeError();
  const CbvhDicingArguments args = cameraAt(0, 0, 5);
  diceGeometry(geometry, &args);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(device.message.find("vertex 1000"), std::string::npos) << device.message;
  rtcReleaseGeometry(geometry);
}

}} // namespace programs::test
