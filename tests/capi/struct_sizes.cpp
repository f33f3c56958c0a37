// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Public structs that begin with structSize, in both interfaces, as passed by applications of older and newer versions.
 * */

#include "kernels/cbvh/operations/errors.h"
#include "kernels/cbvh/operations/struct_size.h"
#include "small_cube.h"
#include "support/message_parts.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <new>
#include <stdexcept>
#include <type_traits>

namespace embree::core {

/* A struct that gained members in its second version. */
struct Grown {
  size_t structSize;
  int a, b;
  double c;
};
CBVH_EXTENSIBLE_STRUCT(Grown, b);

// a function of the library that is not exported
void throwInvalidArgument(const std::string& text) { throw std::invalid_argument(text); }

} // namespace embree::core

namespace programs::test { namespace {

using Bytes = std::vector<char>;

// A struct, and a function of the library that reads or writes it.
struct Case {
  std::string name;
  bool isWritten;
  Bytes valid;                            // of this version
  std::function<std::string(void*)> call; // returns the text of the error, empty if there is none
};

template<typename T>
Case caseOf(const char* name, bool isWritten, const T& valid, const std::function<std::string(T*)>& call) {
  return {name, isWritten, Bytes((const char*)&valid, (const char*)(&valid + 1)),
          [=](void* bytes) { return call((T*)bytes); }};
}

// A committed and traced surface, and a committed and saved geometry.
struct StructSizes : ::testing::Test {
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr, other = nullptr;
  CbvhGroup group = nullptr;
  std::string reported;
  Device device;
  Scene scene{device};
  Folder folder;
  RTCGeometry geometry, cage;
  CbvhFile file = nullptr;
  std::vector<Case> cases;

  StructSizes() {
    const auto keep = [](void* self, CbvhError code, const char* text) {
      EXPECT_EQ(code, CBVH_ERROR_INVALID_ARGUMENT);
      *(std::string*)self = text;
    };
    EXPECT_EQ(cbvhNewContext(nullptr, keep, &reported, &context), CBVH_OK);
    const CbvhCage input = cube();
    for (CbvhSurface* s : {&surface, &other}) {
      EXPECT_EQ(cbvhNewSurface(context, s), CBVH_OK);
      EXPECT_EQ(cbvhSetSurfaceCage(*s, &input), CBVH_OK) << cbvhGetErrorText();
    }
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhNewGroup(context, &surface, 1, &group), CBVH_OK);
    EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();

    Displacement displacement;
    SurfaceSettings settings;
    settings.rate = 8;
    settings.displacement = &displacement;
    geometry = releasing(newSurface(device, cubeCage(), settings), RTC_COMPRESSION_CVERT);
    settings.displacement = nullptr;
    cage = newSurface(device, cubeCage(), settings);
    rtcCommitGeometry(cage);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    EXPECT_TRUE(saveGeometryFile(geometry, (folder / "one").c_str())) << device.message;
    file = openFile(device, (folder / "one").c_str());
    EXPECT_NE(file, nullptr) << device.message;
    addCases();
    addCbvhCases();
  }

  ~StructSizes() override {
    releaseFile(file);
    rtcReleaseGeometry(cage);
    rtcReleaseGeometry(geometry);
    cbvhReleaseGroup(group);
    cbvhReleaseSurface(other);
    cbvhReleaseSurface(surface);
    cbvhReleaseContext(context);
  }

  std::string error() {
    const RTCError code = device.takeError();
    if (code == RTC_ERROR_NONE) return "";
    EXPECT_EQ(code, RTC_ERROR_INVALID_ARGUMENT);
    return device.message;
  }

  static std::string error(CbvhError code) {
    if (code == CBVH_OK) return "";
    EXPECT_EQ(code, CBVH_ERROR_INVALID_ARGUMENT);
    return cbvhGetErrorText();
  }

  void addCases() {
    RTCCompressionArguments compression;
    rtcInitCompressionArguments(&compression);
    cases.push_back(caseOf<RTCCompressionArguments>("RTCCompressionArguments", false, compression,
                                                    [=](RTCCompressionArguments* args) {
                                                      rtcSetGeometryCompression(cage, args);
                                                      const std::string text = error();
                                                      rtcCommitGeometry(cage);
                                                      return text;
                                                    }));
    cases.push_back(caseOf<RTCCompressionStatistics>("RTCCompressionStatistics", true, {},
                                                     [=](RTCCompressionStatistics* statistics) {
                                                       rtcGetSceneCompressionStatistics(scene, statistics);
                                                       return error();
                                                     }));
    cases.push_back(
        caseOf<CbvhSurfaceStatistics>("CbvhSurfaceStatistics", true, {}, [=](CbvhSurfaceStatistics* statistics) {
          statisticsOf(file, 0, statistics);
          return error();
        }));
    cases.push_back(caseOf<CbvhFileSurfaceInfo>("CbvhFileSurfaceInfo", true, {}, [=](CbvhFileSurfaceInfo* info) {
      infoOf(file, 0, info);
      return error();
    }));
  }

  void addCbvhCases() {
    cases.push_back(caseOf<CbvhCage>("CbvhCage", false, cube(),
                                     [=](CbvhCage* input) { return error(cbvhSetSurfaceCage(other, input)); }));
    static const CbvhGrid grid = {0, 2, 2, 4};
    cases.push_back(caseOf<CbvhGrids>("CbvhGrids", false, {sizeof(CbvhGrids), 1, &grid, cube().vertices},
                                      [=](CbvhGrids* input) { return error(cbvhSetSurfaceGrids(other, input)); }));
    cases.push_back(caseOf<CbvhMesh>("CbvhMesh", false, {sizeof(CbvhMesh), 4, 6, cubeIndices, cube().vertices},
                                     [=](CbvhMesh* input) { return error(cbvhSetSurfaceMesh(other, input)); }));
    CbvhDicingArguments dicing = CbvhDicingArguments();
    dicing.pixelSize = 0.1f;
    cases.push_back(caseOf<CbvhDicingArguments>("CbvhDicingArguments", false, dicing, [=](CbvhDicingArguments* input) {
      const CbvhCage again = cube();
      EXPECT_EQ(cbvhSetSurfaceCage(other, &again), CBVH_OK);
      return error(cbvhDiceSurface(other, input, nullptr));
    }));
    cases.push_back(caseOf<CbvhAccuracy>(
        "CbvhAccuracy", false, {}, [=](CbvhAccuracy* input) { return error(cbvhSetSurfaceAccuracy(other, input)); }));
    static const float uv[1] = {0.5f};
    static float P[2];
    cases.push_back(caseOf<CbvhInterpolationPoints>(
        "CbvhInterpolationPoints", false, {sizeof(CbvhInterpolationPoints), 0, 0, 1, uv, uv, P, nullptr, nullptr},
        [=](CbvhInterpolationPoints* points) { return error(cbvhInterpolateAttributeAtPoints(surface, points)); }));
    const auto trace = [=](bool isOcclusion) {
      return [=](CbvhQuery* query) {
        reported.clear();
        CbvhRayHit r = rayFromAbove();
        const int isHit = isOcclusion ? cbvhOccluded1(group, &r.ray, query) : cbvhIntersect1(group, &r, query);
        EXPECT_EQ(isHit != 0, reported.empty()) << reported;
        return reported;
      };
    };
    cases.push_back(caseOf<CbvhQuery>("CbvhQuery", false, {}, trace(false)));
    cases.push_back(caseOf<CbvhQuery>("CbvhQuery", false, {}, trace(true)));
    cases.push_back(caseOf<CbvhPointQuery>("CbvhPointQuery", false, {sizeof(CbvhPointQuery), 0, 0, 5, 0, INFINITY},
                                           [=](CbvhPointQuery* query) {
                                             reported.clear();
                                             const int isFound = cbvhPointQuery(group, query, nullptr);
                                             EXPECT_EQ(isFound != 0, reported.empty()) << reported;
                                             return reported;
                                           }));
    const auto packet = [=](bool isOcclusion) {
      return [=](CbvhQuery* query) {
        reported.clear();
        alignas(16) RTCRayHit4 rays = RTCRayHit4();
        for (int i = 0; i < 4; i++) {
          rays.ray.org_x[i] = rays.ray.org_y[i] = 0.01f;
          rays.ray.org_z[i] = 5;
          rays.ray.dir_z[i] = -1;
          rays.ray.tfar[i] = INFINITY;
          rays.ray.mask[i] = 1;
        }
        const unsigned hits =
            isOcclusion ? cbvhOccluded4(group, nullptr, &rays, query) : cbvhIntersect4(group, nullptr, &rays, query);
        EXPECT_EQ(hits, reported.empty() ? 15u : 0u) << reported;
        return reported;
      };
    };
    cases.push_back(caseOf<CbvhQuery>("CbvhQuery", false, {}, packet(false)));
    cases.push_back(caseOf<CbvhQuery>("CbvhQuery", false, {}, packet(true)));
    cases.push_back(caseOf<CbvhGroupStatistics>("CbvhGroupStatistics", true, {}, [=](CbvhGroupStatistics* statistics) {
      return error(cbvhGetGroupStatistics(group, statistics));
    }));
    cases.push_back(
        caseOf<CbvhClusterStatistics>("CbvhClusterStatistics", true, {}, [=](CbvhClusterStatistics* report) {
          return error(cbvhForEachCluster(surface, 0, CBVH_CLUSTER_FORMAT_DGF1, nullptr, nullptr, report));
        }));
  }

  // A struct of another version: tail bytes are appended, and structSize is set.
  static Bytes withSize(const Case& of, size_t structSize, const Bytes& tail) {
    Bytes bytes = of.valid;
    bytes.insert(bytes.end(), tail.begin(), tail.end());
    std::memcpy(bytes.data(), &structSize, sizeof(structSize));
    return bytes;
  }

  static void expectRefused(const Case& of, Bytes bytes, const char* what) {
    size_t size;
    std::memcpy(&size, bytes.data(), sizeof(size));
    const Bytes before = bytes;
    EXPECT_TRUE(containsInOrder(of.call(bytes.data()),
                                {of.name, "structSize", std::to_string(size), std::to_string(of.valid.size())}))
        << what;
    EXPECT_EQ(bytes, before) << what;
  }
};

TEST_F(StructSizes, DefaultsAreTheSizesOfThisVersion) {
  for (const Case& c : cases) {
    size_t size;
    std::memcpy(&size, c.valid.data(), sizeof(size));
    EXPECT_EQ(size, c.valid.size()) << c.name;
  }
}

TEST_F(StructSizes, ZeroTooSmallAndTooLargeAreRejected) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    expectRefused(c, withSize(c, 0, {}), "zero");
    expectRefused(c, withSize(c, 8, {}), "structSize alone");
    expectRefused(c, withSize(c, c.valid.size() - 1, {}), "a byte less");
    expectRefused(c, withSize(c, 4104, Bytes(4104)), "more than 4096");
    expectRefused(c, withSize(c, ~size_t(0), {}), "all bits");
  }
}

TEST_F(StructSizes, ThisVersionIsAccepted) {
  for (const Case& c : cases) {
    Bytes bytes = c.valid;
    EXPECT_EQ(c.call(bytes.data()), "") << c.name;
    EXPECT_EQ(bytes != c.valid, c.isWritten) << c.name;
  }
}

TEST_F(StructSizes, NewerInputIsAcceptedIfItsNewMembersAreZero) {
  for (const Case& c : cases) {
    if (c.isWritten) continue;
    SCOPED_TRACE(c.name);
    const size_t size = c.valid.size() + 24;
    Bytes zeros = withSize(c, size, Bytes(24));
    EXPECT_EQ(c.call(zeros.data()), "");
    for (size_t at : {0, 23}) {
      Bytes tail(24);
      tail[at] = 1;
      expectRefused(c, withSize(c, size, tail), "a byte that is not zero");
    }
    Bytes most = withSize(c, 4096, Bytes(4096 - c.valid.size()));
    EXPECT_EQ(c.call(most.data()), "");
  }
}

TEST_F(StructSizes, NewerOutputIsFilledWithZeros) {
  for (const Case& c : cases) {
    if (!c.isWritten) continue;
    SCOPED_TRACE(c.name);
    Bytes expected = c.valid;
    ASSERT_EQ(c.call(expected.data()), "");
    const size_t known = expected.size(), size = known + 24;
    Bytes bytes = withSize(c, size, Bytes(32, 7));
    ASSERT_EQ(c.call(bytes.data()), "");
    size_t kept;
    std::memcpy(&kept, bytes.data(), sizeof(kept));
    EXPECT_EQ(kept, size);
    EXPECT_TRUE(std::equal(bytes.begin() + 8, bytes.begin() + known, expected.begin() + 8)) << "members";
    EXPECT_EQ(Bytes(bytes.begin() + known, bytes.begin() + size), Bytes(24)) << "new members";
    EXPECT_EQ(Bytes(bytes.begin() + size, bytes.end()), Bytes(8, 7)) << "bytes outside of the struct";
  }
}

// An application of the first version passes a struct that has since gained members.
TEST(StructGrowth, MissingMembersAreZeroAndNotWritten) {
  using embree::core::Grown;
  Grown application = {16, 3, 4, 5.0};
  const Grown read = embree::core::readStruct(&application);
  EXPECT_EQ(read.structSize, sizeof(Grown));
  EXPECT_EQ(read.a, 3);
  EXPECT_EQ(read.b, 4);
  EXPECT_EQ(read.c, 0.0);
  embree::core::writeStruct(&application, Grown{sizeof(Grown), 6, 7, 8.0});
  EXPECT_EQ(application.structSize, 16u);
  EXPECT_EQ(application.a, 6);
  EXPECT_EQ(application.b, 7);
  EXPECT_EQ(application.c, 5.0) << "outside of the struct";
  application.structSize = 15;
  EXPECT_THROW(embree::core::requireStruct(&application), std::invalid_argument);
  application.structSize = 20; // ends inside a member
  EXPECT_THROW(embree::core::readStruct(&application), std::invalid_argument);
}

// Default initialization, as in `CbvhCage cage;`. Not inlined, so that the caller's bytes remain where it writes none.
template<typename T>
__attribute__((noinline)) void initialize(void* memory) {
  new (memory) T;
}

// Checks default initialization in memory that is not zero. Bytes between members keep their values.
template<typename T>
void expectDefaults(const T& defaults) {
  static_assert(std::is_aggregate_v<T>, "brace initialization must remain possible");
  SCOPED_TRACE(testing::internal::GetTypeName<T>());
  alignas(T) unsigned char memory[2][sizeof(T)], expected[sizeof(T)];
  std::memcpy(expected, &defaults, sizeof(T));
  for (int i = 0; i < 2; i++) {
    std::memset(memory[i], 0xAB + i, sizeof(T));
    initialize<T>(memory[i]);
  }
  size_t untouched = 0;
  for (size_t i = 0; i < sizeof(T); i++) {
    const bool isTouched = memory[0][i] == memory[1][i];
    untouched += !isTouched;
    if (isTouched) { EXPECT_EQ(memory[0][i], expected[i]) << "byte " << i; }
  }
  EXPECT_LE(untouched, 12u) << "only padding";
}

TEST(DefaultMemberInitializers, SetAllMembers) {
  RTCCompressionArguments arguments;
  std::memset((void*)&arguments, 0, sizeof(arguments));
  rtcInitCompressionArguments(&arguments);
  expectDefaults(arguments);
  const auto zeros = [](auto value) {
    std::memset((void*)&value, 0, sizeof(value));
    value.structSize = sizeof(value);
    expectDefaults(value);
  };
  zeros(CbvhCage());
  zeros(CbvhGrids());
  zeros(CbvhMesh());
  zeros(CbvhDicingArguments());
  zeros(CbvhAccuracy());
  zeros(CbvhInterpolationPoints());
  zeros(CbvhGroupStatistics());
  zeros(CbvhQuery());
  zeros(CbvhPointQuery());
  zeros(CbvhClusterStatistics());
  zeros(RTCCompressionStatistics());
  zeros(CbvhFileSurfaceInfo());
  zeros(CbvhSurfaceStatistics());
  CbvhVertices vertices;
  std::memset((void*)&vertices, 0, sizeof(vertices));
  expectDefaults(vertices);
  CbvhAttribute attribute;
  std::memset((void*)&attribute, 0, sizeof(attribute));
  expectDefaults(attribute);
}

}} // namespace programs::test
