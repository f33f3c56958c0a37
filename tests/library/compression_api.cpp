// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Settings, statistics, memory, progress and rebuilding, through the API. */

#include "support/environment.h"
#include "support/memory.h"
#include "support/message_parts.h"
#include "support/random.h"
#include "support/scene.h"
#include "support/turkish_locale.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <locale>
#include <malloc.h>
#include <mutex>

namespace programs::test { namespace {

// According to the statistics of the cube's scene.
std::string representationOf(RTCScene scene) {
  const RTCCompressionStatistics s = statisticsOf(scene);
  if (s.numBlocks == 0) return "none";
  if (s.maxVertexSpacing > 0) return "exact";
  // leaves have no bytes, 2 bytes per quad (at least 8), or 12 per vertex; and up to 12 bytes align the next block
  const size_t leaves = s.leafBytes / s.numBlocks, quads = s.numQuads / s.numBlocks;
  std::string name = leaves < 16 ? "voxel" : leaves <= std::max<size_t>(2 * quads, 8) + 12 ? "leaf" : "grid";
  for (int n = 0; n <= 8; n++)
    if (s.numBlocks == 6 * (size_t(1) << 2 * n)) name += " " + std::to_string(n);
  return name;
}

// Representation of a cube on a device with this configuration.
std::string representation(const std::string& config, const RTCCompressionArguments* args = nullptr, float rate = 32) {
  const bool says = !config.empty() || getenv("EMBREE_CBVH");
  Device device(says ? "cbvh_fallback_faces=0," + config : config); // the number of blocks reveals the frame level
  if (!device) return "no device";
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = rate;
  Scene scene(device);
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  if (args) rtcSetGeometryCompression(geometry, args);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  return representationOf(scene);
}

RTCCompressionArguments arguments(RTCCompression compression, int frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT,
                                  float maxError = -1) {
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = compression;
  args.frameLevel = frameLevel;
  args.maxError = maxError;
  args.fallbackFaces = 0; // the number of blocks reveals the frame level
  return args;
}

// --- settings --------------------------------------------------------------------------------

TEST(Settings, DefaultIsStock) {
  EXPECT_EQ(representation(""), "none");
  EXPECT_EQ(representation("threads=1"), "none");
  EXPECT_EQ(representation("subdiv_accel=bvh4.grid.eager"), "none");
  EXPECT_EQ(representation("cbvh_frame_level=1"), "none");
}

TEST(Settings, DeviceStringChoosesTheRepresentation) {
  EXPECT_EQ(representation("subdiv_accel=cbvh.grid"), "grid 1");
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel"), "voxel 1");
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf"), "leaf 1");
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=0"), "leaf 0");
  EXPECT_EQ(representation("cbvh_frame_level=3,subdiv_accel=cbvh.leaf"), "leaf 3");
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=auto"), "leaf 1");
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=auto,cbvh_max_error=1e-30"), "leaf 5");
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=8"), "leaf 5");
}

TEST(Settings, DefaultFrameLevelGivesBlocksOf16x16Quads) {
  const char* const expected[] = {"leaf 0", "leaf 0", "leaf 0", "leaf 0", "leaf 0", "leaf 1", "leaf 2"};
  for (unsigned level = 0; level <= 6; level++)
    EXPECT_EQ(representation("subdiv_accel=cbvh.leaf", nullptr, float(1u << level)), expected[level]) << level;
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=2", nullptr, 4), "leaf 2");
}

TEST(Settings, EnvironmentIsUsedIfProgramSetsNothing) {
  const std::pair<const char*, const char*> cases[] = {{"leaf", "leaf 1"},
                                                       {"voxel,frame_level=1", "voxel 1"},
                                                       {" leaf , frame_level=auto ", "leaf 1"},
                                                       {"leaf,frame_level=auto,max_error=1e-30", "leaf 5"},
                                                       {"none", "none"},
                                                       {"0", "none"},
                                                       {"", "none"},
                                                       {"frame_level=1", "none"},
                                                       {"grid,level=3", "grid 3"}}; // the former name of frame_level
  for (const auto& c : cases) {
    Environment environment(c.first);
    EXPECT_EQ(representation(""), c.second) << c.first;
  }
}

TEST(Settings, GeometryOverridesDeviceOverridesEnvironment) {
  Environment environment("leaf,frame_level=1");
  EXPECT_EQ(representation(""), "leaf 1");
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel"), "voxel 1");
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel,cbvh_frame_level=3"), "voxel 3");
  EXPECT_EQ(representation("cbvh_frame_level=3"), "leaf 3");
  EXPECT_EQ(representation("subdiv_accel=bvh4.grid.eager"), "none");
  RTCCompressionArguments args = arguments(RTC_COMPRESSION_CGRID);
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel,cbvh_frame_level=3", &args), "grid 3");
  args = arguments(RTC_COMPRESSION_INHERIT, 0);
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel,cbvh_frame_level=3", &args), "voxel 0");
  args = arguments(RTC_COMPRESSION_NONE);
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel", &args), "none");
  args = arguments(RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_FRAME_LEVEL_AUTO, 1e-30f);
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel", &args), "leaf 5");
}

TEST(Settings, DefaultKindIsTiles) {
  const auto leafBytes = [](const std::string& config) {
    Device device(config);
    SurfaceSettings settings;
    settings.rate = 32;
    const SurfaceScene scene(device, cubeCage(), settings);
    return statisticsOf(scene).leafBytes;
  };
  EXPECT_EQ(leafBytes("subdiv_accel=cbvh"), leafBytes("subdiv_accel=cbvh.tile"));
  EXPECT_GT(leafBytes("subdiv_accel=cbvh"), leafBytes("subdiv_accel=cbvh.vert"));
  Environment environment("1");
  EXPECT_EQ(leafBytes(""), leafBytes("subdiv_accel=cbvh.tile"));
}

TEST(Settings, OneSelectsDefaultKind) {
  EXPECT_EQ(representation("subdiv_accel=cbvh"), "exact");
  Environment environment("1");
  EXPECT_EQ(representation(""), "exact");
  EXPECT_EQ(representation("subdiv_accel=cbvh.voxel,cbvh_frame_level=3"), "voxel 3");
}

TEST(Version, LibraryAndHeadersAgree) {
  Device device("");
  EXPECT_EQ(rtcGetDeviceCompressionProperty(device, RTC_COMPRESSION_PROPERTY_VERSION), RTC_COMPRESSION_VERSION);
  const ssize_t major = rtcGetDeviceCompressionProperty(device, RTC_COMPRESSION_PROPERTY_VERSION_MAJOR);
  const ssize_t minor = rtcGetDeviceCompressionProperty(device, RTC_COMPRESSION_PROPERTY_VERSION_MINOR);
  const ssize_t patch = rtcGetDeviceCompressionProperty(device, RTC_COMPRESSION_PROPERTY_VERSION_PATCH);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch),
            RTC_COMPRESSION_VERSION_STRING);
  EXPECT_EQ(major * 10000 + minor * 100 + patch, RTC_COMPRESSION_VERSION);

  EXPECT_EQ(rtcGetDeviceCompressionProperty(device, RTCCompressionProperty(4)), 0);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(device.message.find("RTCCompressionProperty 4"), std::string::npos) << device.message;
  EXPECT_EQ(rtcGetDeviceCompressionProperty(nullptr, RTC_COMPRESSION_PROPERTY_VERSION), 0);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
}

// With the kind chosen by the device string or by the environment.
TEST(Version, IsPrintedAboveTheBannerOfVerboseDevicesOnly) {
  const auto printed = [](const std::string& config) {
    testing::internal::CaptureStdout();
    { Device device(config); }
    return testing::internal::GetCapturedStdout();
  };
  const std::string name = "Embree CBVH " RTC_COMPRESSION_VERSION_STRING "\n";
  EXPECT_EQ(printed(""), "");
  Environment environment("leaf");
  for (const auto& c :
       {std::make_pair("verbose=1", "cLEAF"), std::make_pair("verbose=1,subdiv_accel=cbvh.vert", "cVERT"),
        std::make_pair("verbose=1,subdiv_accel=bvh4.grid.eager", "GRID")}) {
    const std::string text = printed(c.first);
    const size_t ours = text.find(name), kind = text.find(c.second, ours),
                 banner = text.find("Embree Ray Tracing Kernels");
    EXPECT_LT(ours, kind) << text;
    EXPECT_LT(kind, banner) << text;
    EXPECT_NE(banner, std::string::npos) << text;
  }
}

// In a C++ locale with decimal commas.
TEST(Settings, NumbersUseDecimalPointInEveryLocale) {
  struct Comma : public std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=auto,cbvh_max_error=1000.5"), "leaf 0");
  EXPECT_EQ(representation("subdiv_accel=cbvh.leaf,cbvh_frame_level=auto,cbvh_max_error=0.0000001"), "leaf 5");
  Environment environment("leaf,frame_level=auto,max_error=0.0000001");
  EXPECT_EQ(representation(""), "leaf 5");
  std::locale::global(before);
}

// There is no device for an error message: rtcNewDevice prints a line to stderr and sets the error code.
void expectNoDevice(const std::string& config, const std::string& name, const std::string& value) {
  rtcGetDeviceError(nullptr);
  testing::internal::CaptureStderr();
  RTCDevice device = rtcNewDevice(config.c_str());
  const std::string output = testing::internal::GetCapturedStderr();
  EXPECT_EQ(device, nullptr) << config;
  if (device) rtcReleaseDevice(device);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT) << config;
  EXPECT_TRUE(containsInOrder(output, {"\"" + value + "\"", name})) << config;
}

TEST(Settings, UnknownValuesInDeviceStringAreRejectedByNameAndValue) {
  expectNoDevice("subdiv_accel=cbvh.foo", "subdiv_accel", "cbvh.foo");
  expectNoDevice("subdiv_accel=cbvh.", "subdiv_accel", "cbvh.");
  expectNoDevice("subdiv_accel=cbvhvert", "subdiv_accel", "cbvhvert");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_frame_level=9", "cbvh_frame_level", "9");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_frame_level=-1", "cbvh_frame_level", "-1");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_frame_level=x", "cbvh_frame_level", "x");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_frame_level", "cbvh_frame_level", "");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_frame_level=2.5", "cbvh_frame_level", "2.5");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_max_error=-1", "cbvh_max_error", "-1");
  expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_max_error=x", "cbvh_max_error", "x");
}

// Embree's lexer reads other numbers from these texts: it cuts integers to 32 bits and ends tokens within the text.
TEST(Settings, ValuesInDeviceStringAreReadCompletely) {
  for (const std::string level : {"4294967298", "18446744073709551618", "2x", "0x2", "2 3", "2 -", "auto2", "\"2\""})
    expectNoDevice("subdiv_accel=cbvh.leaf,cbvh_frame_level=" + level, "cbvh_frame_level", level);
  for (const std::string error : {"0x10", "5e", "1 2", "1 .5", "0.5;", "1=2", "inf", "1e99", "-2147483649"})
    for (const std::string last : {"", ",threads=1", " threads=1"})
      expectNoDevice("cbvh_max_error=" + error + last, "cbvh_max_error", error);
  expectNoDevice("cbvh_quads=1 0", "cbvh_quads", "1 0");
  expectNoDevice("cbvh_quads=4294967297", "cbvh_quads", "4294967297");
  for (const std::string error : {"2147483648", "4294967296", "0.5", ".5", "5.", "5e-1", "+5E+1", " 5", "5 "})
    for (const std::string last : {"", ",verbose=0", " verbose=0"}) {
      RTCDevice device = rtcNewDevice(("cbvh_max_error=" + error + last).c_str());
      EXPECT_NE(device, nullptr) << error << last;
      if (device) rtcReleaseDevice(device);
    }
  EXPECT_EQ(representation("cbvh_frame_level= 2 subdiv_accel=cbvh.leaf"), "leaf 2");
  EXPECT_EQ(representation("cbvh_frame_level= auto\tcbvh_max_error=4294967296\nsubdiv_accel=cbvh.leaf"), "leaf 0");
}

// Embree ignores other unknown keys silently.
TEST(Settings, UnknownKeysAreRejectedWithSuggestion) {
  expectNoDevice("subdiv_accel=cbvh,cbvh_maxerror=0.001", "cbvh_max_error", "cbvh_maxerror");
  expectNoDevice("cbvh_framelevel=2", "cbvh_frame_level", "cbvh_framelevel");
  expectNoDevice("cbvh_fallback=1", "cbvh_fallback_faces", "cbvh_fallback");
  expectNoDevice("subdiv_accel=cbvh,max_error=0.001", "cbvh_max_error", "max_error");
  expectNoDevice("cbvh=vert", "device string", "cbvh");
  const std::string items[][2] = {{"maxerror=0.001", "max_error"},
                                  {"error=0.001", "max_error"},
                                  {"tri=1", "triangles"},
                                  {"quads", "quads=<value>"}};
  for (const auto& item : items) {
    Environment environment(("vert," + item[0]).c_str());
    expectNoDevice("", item[1], item[0]);
  }
}

// "grid" is Embree's GRID in subdiv_accel and in programs that offer both, and cGRID elsewhere.
TEST(Settings, NamesOfKindsAreAcceptedEverywhere) {
  const std::string kinds[] = {"grid", "voxel", "leaf", "vert", "tile"};
  for (const std::string& kind : kinds) {
    const std::string expected = representation("subdiv_accel=cbvh." + kind);
    std::string upper = "cbvh." + kind;
    for (char& c : upper) c = char(std::toupper(c));
    for (const std::string& name : {"c" + kind, "C" + kind, upper, kind}) {
      SCOPED_TRACE(name);
      if (name != "grid") { EXPECT_EQ(representation("subdiv_accel=" + name), expected); }
      Environment environment(name.c_str());
      EXPECT_EQ(representation(""), expected);
    }
  }
  EXPECT_EQ(representation("subdiv_accel=CBVH"), representation("subdiv_accel=cbvh"));
}

TEST(Settings, NamesOfKindsDoNotDependOnTheLocale) {
  const std::string expected = representation("subdiv_accel=cbvh.grid");
  const TurkishLocale locale;
  if (!locale) GTEST_SKIP() << "no localedef, or no source of the Turkish locale: install Debian's package locales";
  ASSERT_NE(std::tolower('I'), 'i');
  EXPECT_EQ(representation("subdiv_accel=CBVH.GRID"), expected);
}

TEST(Settings, GeometriesCanOptOutOfEveryKind) {
  for (const char* name : {"cvert", "vert", "cbvh.vert", "CBVH"}) {
    Device device(std::string("subdiv_accel=") + name);
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_NONE;
    const SurfaceScene scene(device, cubeCage(), settings);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << name << ": " << device.message;
    EXPECT_EQ(statisticsOf(scene).numQuads, 0u);
  }
}

TEST(Settings, UnknownValuesInEnvironmentAreRejectedByNameAndValue) {
  const std::pair<const char*, const char*> cases[] = {{"foo", "foo"},
                                                       {"leaf,frame_level=9", "9"},
                                                       {"leaf,frame_level=-1", "-1"},
                                                       {"leaf,frame_level=", ""},
                                                       {"leaf,frame_level=2x", "2x"},
                                                       {"leaf,level=9", "9"},
                                                       {"2", "2"},
                                                       {"leaf,max_error=-1", "-1"},
                                                       {"leaf,max_error=nan", "nan"},
                                                       {"leaf,paint=2", "paint=2"},
                                                       {"leaf,verbose=yes", "yes"},
                                                       {"leaf,verbose=-1", "-1"},
                                                       {"leaf,verbose=", ""},
                                                       {"cbvh.foo", "cbvh.foo"},
                                                       {"cgrids", "cgrids"}};
  for (const auto& c : cases) {
    Environment environment(c.first);
    expectNoDevice("", "EMBREE_CBVH", c.second);
  }
}

// --- errors of the functions --------------------------------------------------------------------

TEST(SetGeometryCompression, RejectsBadArgumentsByNameAndValueAndKeepsTheSetting) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CVOXEL;
  settings.frameLevel = 1;
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);

  auto expectError = [&](const RTCCompressionArguments* args, const char* name, const std::string& value) {
    rtcSetGeometryCompression(geometry, args);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << name << " " << value;
    EXPECT_NE(device.message.find(name), std::string::npos) << device.message;
    EXPECT_NE(device.message.find(value), std::string::npos) << device.message;
  };
  expectError(nullptr, "args", "NULL");
  for (int value : {-1, 7, 99, 1 << 30}) {
    RTCCompressionArguments args = arguments(RTC_COMPRESSION_CLEAF);
    std::memcpy(&args.compression, &value, sizeof(value));
    expectError(&args, "compression", std::to_string(value));
  }
  for (int value : {-3, 9, -(1 << 30), 1 << 30}) {
    const RTCCompressionArguments args = arguments(RTC_COMPRESSION_CLEAF, value);
    expectError(&args, "frameLevel", std::to_string(value));
  }
  for (unsigned value : {4u, 5u, ~0u}) {
    RTCCompressionArguments args = arguments(RTC_COMPRESSION_CLEAF);
    args.flags = value;
    expectError(&args, "flags", std::to_string(value));
  }
  for (float value : {INFINITY, -INFINITY, NAN}) {
    const RTCCompressionArguments args = arguments(RTC_COMPRESSION_CLEAF, 2, value);
    expectError(&args, "maxError", std::isnan(value) ? "nan" : "inf");
  }

  for (float value : {-1.0f, INFINITY, NAN}) {
    RTCCompressionArguments args = arguments(RTC_COMPRESSION_CVERT);
    args.maxPixelError = value;
    args.pixelSize = 1;
    expectError(&args, "maxPixelError", std::isnan(value) ? "nan" : std::isinf(value) ? "inf" : "-1");
  }
  for (float value : {0.0f, -2.0f, INFINITY}) {
    RTCCompressionArguments args = arguments(RTC_COMPRESSION_CVERT);
    args.maxPixelError = 1;
    args.pixelSize = value;
    expectError(&args, "pixelSize", std::isinf(value) ? "inf" : value < 0 ? "-2" : "0");
  }
  {
    RTCCompressionArguments args = arguments(RTC_COMPRESSION_CVERT);
    args.maxPixelError = args.pixelSize = 1;
    args.cameraPosition[1] = NAN;
    expectError(&args, "cameraPosition", "nan");
  }

  rtcGetDeviceError(nullptr);
  const RTCCompressionArguments args = arguments(RTC_COMPRESSION_CLEAF);
  rtcSetGeometryCompression(nullptr, &args);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);

  Scene scene(device);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(representationOf(scene), "voxel 1");
}

TEST(SetGeometryCompression, RejectsOtherGeometryTypes) {
  Device device;
  const RTCCompressionArguments args = arguments(RTC_COMPRESSION_CLEAF);
  std::vector<RTCGeometryType> types{RTC_GEOMETRY_TYPE_INSTANCE, RTC_GEOMETRY_TYPE_USER};
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_POINT_GEOMETRY_SUPPORTED))
    types.push_back(RTC_GEOMETRY_TYPE_SPHERE_POINT);
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED))
    types.push_back(RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE);
  for (RTCGeometryType type : types) {
    RTCGeometry geometry = rtcNewGeometry(device, type);
    rtcSetGeometryCompression(geometry, &args);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION) << type;
    EXPECT_NE(device.message.find("RTC_GEOMETRY_TYPE_SUBDIVISION"), std::string::npos) << device.message;
    rtcReleaseGeometry(geometry);
  }
}

TEST(GetSceneCompressionStatistics, RejectsNullAndUncommittedScenes) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CLEAF;
  Scene scene(device);
  RTCCompressionStatistics stats;
  rtcGetDeviceError(nullptr);
  rtcGetSceneCompressionStatistics(nullptr, &stats);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  addSurface(device, scene, cubeCage(), settings);
  rtcGetSceneCompressionStatistics(scene, &stats);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  rtcCommitScene(scene);
  rtcGetSceneCompressionStatistics(scene, nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(device.message.find("statistics"), std::string::npos) << device.message;
  rtcGetSceneCompressionStatistics(scene, &stats);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE);
  addSurface(device, scene, cubeCage(), settings);
  rtcGetSceneCompressionStatistics(scene, &stats);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
}

TEST(GetSceneCompressionStatistics, IsAllZeroWithoutCompression) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings);
  rtcCommitScene(scene);
  const RTCCompressionStatistics stats = statisticsOf(scene);
  const RTCCompressionStatistics none = RTCCompressionStatistics();
  EXPECT_EQ(std::memcmp(&stats, &none, offsetof(RTCCompressionStatistics, maxLeafThickness) + sizeof(float)), 0);
}

TEST(GetSceneCompressionStatistics, CountsMatchFormatSpecification) {
  Device device;
  Displacement displacement;
  for (RTCCompression kind : {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF}) {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = kind;
    settings.frameLevel = 1;
    settings.rate = 16; // 24 blocks of height 3
    Scene scene(device);
    addSurface(device, scene, cubeCage(), settings);
    rtcCommitScene(scene);
    const RTCCompressionStatistics s = statisticsOf(scene);
    EXPECT_EQ(s.numBlocks, 24u);
    EXPECT_EQ(s.numQuads, 24u * 64);
    EXPECT_EQ(s.nodeBytes, 24u * 4 * (kind == RTC_COMPRESSION_CGRID ? 5 : 21));
    const size_t leaf = kind == RTC_COMPRESSION_CGRID ? 4 * (3 * 81 + 3) : kind == RTC_COMPRESSION_CLEAF ? 128 : 0;
    EXPECT_GE(s.leafBytes, 24 * leaf);
    EXPECT_LT(s.leafBytes, 24 * (leaf + 16)); // includes the alignment of the next block
    EXPECT_EQ(s.headerBytes, 24u * 76);
    EXPECT_GT(s.topLevelBytes, 0u);
    EXPECT_EQ(s.uncompressedBytes, 0u);
    if (kind != RTC_COMPRESSION_CGRID) { EXPECT_GT(s.maxLeafThickness, 0); }
  }
}

TEST(MaxError, BoundsThicknessOfLeavesWithAutomaticFrameLevel) {
  Device device;
  Displacement displacement;
  for (RTCCompression kind : {RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF}) {
    size_t blocks = 0;
    for (float maxError : {0.2f, 0.05f, 0.02f}) {
      Scene scene(device);
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.rate = 64;
      RTCGeometry geometry = newSurface(device, cubeCage(), settings);
      const RTCCompressionArguments args = arguments(kind, RTC_COMPRESSION_FRAME_LEVEL_AUTO, maxError);
      rtcSetGeometryCompression(geometry, &args);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene, geometry);
      rtcReleaseGeometry(geometry);
      rtcCommitScene(scene);
      const RTCCompressionStatistics s = statisticsOf(scene);
      EXPECT_LE(s.maxLeafThickness, maxError);
      EXPECT_GE(s.numBlocks, blocks) << "a tighter bound must not give coarser frames";
      EXPECT_LT(s.numBlocks, s.numQuads) << "the bound holds before blocks have one quad";
      blocks = s.numBlocks;
    }
  }
}

// --- memory -------------------------------------------------------------------------------------

size_t heapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

struct Sizes {
  size_t result, sum, peak, heap;
};

Sizes measure(RTCCompression kind, const Cage& cage, float rate, const std::string& config = "") {
  Memory memory;
  Sizes sizes;
  {
    Device device(config);
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    const ssize_t before = memory.live;
    {
      Displacement displacement;
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.compression = kind;
      settings.frameLevel = 2;
      settings.rate = rate;
      Scene scene(device);
      addSurface(device, scene, cage, settings);
      const ssize_t input = memory.live;
      const size_t heap = heapBytes();
      memory.peak = input;
      rtcCommitScene(scene);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      sizes.result = size_t(memory.live - input);
      sizes.peak = size_t(memory.peak - input);
      sizes.heap = heapBytes() - heap;
      const RTCCompressionStatistics s = statisticsOf(scene);
      sizes.sum = s.topLevelBytes + s.headerBytes + s.nodeBytes + s.leafBytes + s.uncompressedBytes;
    }
    EXPECT_EQ(memory.live, before) << "the scene must release all memory";
  }
  EXPECT_EQ(memory.live, 0) << "the device must release all memory";
  return sizes;
}

// Topology and regular patches, which the scene also stores, do not depend on the level. The allocator rounds up by a
// few percent and by a block per thread.
TEST(Memory, StatisticsMatchMemoryMonitor) {
  for (RTCCompression kind :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    SCOPED_TRACE(kind);
    const Sizes small = measure(kind, sheetCage(8), 4), large = measure(kind, sheetCage(8), 128);
    const double added = double(large.result) - double(small.result), stated = double(large.sum) - double(small.sum);
    std::printf("compression %d: monitor %zu, statistics %zu, peak %zu\n", int(kind), large.result, large.sum,
                large.peak);
    EXPECT_GE(small.result, small.sum);
    EXPECT_GE(large.result, large.sum);
    EXPECT_LE(added, stated * 1.06 + 256 * 1024);
  }
}

/* A commit needs one patch per thread, whatever the number of faces: 14 floats per vertex (patch_vertices.h) in arrays
 * that grow by doubling, so at most 112 bytes. Blocks are encoded one at a time, 1/16 of the patch each at frame level
 * 2, and the allocator fills its last blocks: 16 more. At this rate the total is 104, with 4 faces as with 36. */
TEST(Memory, CommitPeakIsResultAndOnePatchPerThread) {
  const float rate = 256;
  for (RTCCompression kind :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT})
    for (unsigned threads : {1, 2}) {
      SCOPED_TRACE(testing::Message() << "compression " << kind << ", threads " << threads);
      const Sizes sizes = measure(kind, sheetCage(6), rate, "threads=" + std::to_string(threads));
      const double patch = 128 * double(rate + 1) * double(rate + 1);
      std::printf("compression %d, %u threads: result %zu, peak %zu\n", int(kind), threads, sizes.result, sizes.peak);
      EXPECT_LE(double(sizes.peak), double(sizes.result) + threads * patch);
    }
}

// The growth of malloc's memory during a commit must have gone through the monitor, except for small allocations of
// the C++ library and of TBB.
TEST(Memory, MonitorSeesAllMemory) {
  for (RTCCompression kind :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    SCOPED_TRACE(kind);
    measure(kind, sheetCage(8), 4); // TBB creates its threads and arenas only once
    const Sizes sizes = measure(kind, sheetCage(8), 128);
    EXPECT_LE(sizes.heap, sizes.result + 256 * 1024);
  }
}

// When the displacement function is called, the vertices of a patch exist: malloc must not have allocated more than the
// monitor knows.
TEST(Memory, MonitorSeesAllMemoryDuringCommit) {
  mallopt(M_MMAP_THRESHOLD, 64 * 1024); // the allocator maps large pieces directly
  for (RTCCompression kind :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    SCOPED_TRACE(kind);
    Memory memory;
    Device device("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Displacement displacement;
    size_t heap = 0, calls = 0;
    ssize_t live = 0, unknown = 0;
    displacement.poison = [&](unsigned, float u, float v) {
      if (u != 0 || v != 0) return false;
      calls++;
      unknown = std::max(unknown, ssize_t(heapBytes() - heap) - (memory.live - live));
      return false;
    };
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = kind;
    settings.rate = 256;
    Scene scene(device);
    addSurface(device, scene, sheetCage(2), settings);
    heap = heapBytes();
    live = memory.live;
    rtcCommitScene(scene);
    // cVERT evaluates borders in advance: each corner once for each of its two borders
    EXPECT_EQ(calls, kind == RTC_COMPRESSION_CVERT ? 12u : 4u);
    EXPECT_LE(unknown, 256 * 1024);
    displacement.poison = nullptr;
  }
}

// --- progress -------------------------------------------------------------------------------------

struct Progress {
  std::vector<double> fractions;
  double cancelAt = 2;
  std::mutex mutex;

  static bool monitor(void* self, double n) {
    Progress& p = *(Progress*)self;
    std::lock_guard<std::mutex> lock(p.mutex);
    p.fractions.push_back(n);
    return n < p.cancelAt;
  }
};

TEST(Progress, RisesToOne) {
  // a task of eight faces reports at its end, and after every 2^15 quads: at rate 256 after each face
  for (const auto& tasks : {std::make_pair(64.0f, sheetCage(12)), std::make_pair(256.0f, sheetCage(3))}) {
    SCOPED_TRACE(testing::Message() << "rate " << tasks.first);
    Device device("threads=1"); // with one thread, calls are in order
    Displacement displacement;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = RTC_COMPRESSION_CLEAF;
    settings.rate = tasks.first;
    Scene scene(device);
    addSurface(device, scene, tasks.second, settings);
    Progress progress;
    rtcSetSceneProgressMonitorFunction(scene, Progress::monitor, &progress);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    ASSERT_GT(progress.fractions.size(), 5u);
    EXPECT_TRUE(std::is_sorted(progress.fractions.begin(), progress.fractions.end()));
    EXPECT_LT(progress.fractions.front(), 0.3);
    EXPECT_GT(progress.fractions.back(), 0.9);
    EXPECT_LE(progress.fractions.back(), 1.001);
  }
}

TEST(Progress, CancelledCommitCanBeRepeated) {
  Memory memory;
  for (RTCCompression kind :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    {
      Device device;
      rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
      Displacement displacement;
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.compression = kind;
      settings.rate = 32;
      Scene scene(device), whole(device);
      addSurface(device, scene, sheetCage(16), settings);
      addSurface(device, whole, sheetCage(16), settings);
      rtcCommitScene(whole);
      Progress progress;
      rtcSetSceneProgressMonitorFunction(scene, Progress::monitor, &progress);
      for (double at : {0.0, 0.3, 0.7}) {
        progress.cancelAt = at;
        rtcCommitScene(scene);
        EXPECT_EQ(device.takeError(), RTC_ERROR_CANCELLED) << at;
      }
      progress.cancelAt = 2;
      rtcCommitScene(scene);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      Random random(81);
      for (int i = 0; i < 500; i++) {
        const RTCRayHit ray =
            makeRay({float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), 3}, {0.01f, 0.02f, -1});
        const RTCRayHit a = intersect(whole, ray), b = intersect(scene, ray);
        ASSERT_EQ(isHit(a), isHit(b));
        if (isHit(a)) { ASSERT_EQ(a.ray.tfar, b.ray.tfar); }
      }
    }
    EXPECT_EQ(memory.live, 0);
  }
}

// --- rebuilding -------------------------------------------------------------------------------------

TEST(Dynamic, ScenesFollowChanges) {
  for (RTCCompression kind :
       {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    Memory memory;
    Device device;
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Displacement displacement;
    displacement.amplitude = 0.01f;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = kind;
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    Cage cage = cubeCage();
    addSurface(device, scene, cage, settings);
    rtcCommitScene(scene);
    RTCGeometry geometry = rtcGetGeometry(scene, 0);
    ssize_t live = 0;
    for (int frame = 0; frame < 20; frame++) {
      float* positions = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
      const float x = float(frame % 4);
      for (size_t i = 0; i < cage.positions.size(); i++) positions[3 * i] = cage.positions[i][0] + x;
      rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
      rtcSetGeometryTessellationRate(geometry, frame % 2 ? 8 : 16);
      rtcCommitGeometry(geometry);
      rtcCommitScene(scene);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      ASSERT_EQ(statisticsOf(scene).numQuads, 6u * (frame % 2 ? 64 : 256));
      const RTCRayHit hit = intersect(scene, makeRay({x, 0, 5}, {0, 0, -1}));
      ASSERT_TRUE(isHit(hit)) << "frame " << frame;
      ASSERT_FALSE(isHit(intersect(scene, makeRay({x + 2, 0, 5}, {0, 0, -1}))));
      if (frame == 7) live = memory.live;
      if (frame > 7 && frame % 4 == 3) { ASSERT_LE(memory.live, live + 64 * 1024) << "rebuilding grows"; }
    }
  }
}

TEST(Dynamic, SettingsTakeEffectWithTheNextCommit) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  addSurface(device, scene, cubeCage(), settings);
  RTCGeometry geometry = rtcGetGeometry(scene, 0);
  const struct {
    RTCCompression kind;
    int frameLevel;
    const char* name;
  } steps[] = {{RTC_COMPRESSION_INHERIT, 2, "none"}, {RTC_COMPRESSION_CLEAF, 2, "leaf 2"},
               {RTC_COMPRESSION_CLEAF, 0, "leaf 0"}, {RTC_COMPRESSION_CGRID, 1, "grid 1"},
               {RTC_COMPRESSION_NONE, 1, "none"},    {RTC_COMPRESSION_CVOXEL, 4, "voxel 4"},
               {RTC_COMPRESSION_INHERIT, 0, "none"}};
  for (const auto& step : steps) {
    const RTCCompressionArguments args = arguments(step.kind, step.frameLevel);
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(representationOf(scene), step.name);
    EXPECT_TRUE(isHit(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1}))));
  }
}

// Embree ignores unknown keys, but a misspelled request for compression must not be ignored.
TEST(DeviceString, UnknownKeysGetSuggestion) {
  for (const char* config : {"subdiv_acel=cbvh", "threds=1,subdiv_accel=cbvh.vert"}) {
    testing::internal::CaptureStderr();
    RTCDevice device = rtcNewDevice(config);
    const std::string printed = testing::internal::GetCapturedStderr();
    EXPECT_EQ(device, nullptr) << config;
    EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
    const bool isAccel = config[0] == 's';
    EXPECT_TRUE(isAccel ? containsInOrder(printed, {"\"subdiv_acel\"", "subdiv_accel"})
                        : containsInOrder(printed, {"\"threds\"", "threads"}));
  }
  RTCDevice device = rtcNewDevice("threds=1,unknown,grid_accel=default"); // accepted, as by stock Embree
  ASSERT_NE(device, nullptr);
  rtcReleaseDevice(device);
}

}} // namespace programs::test
