// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cVERT moves vertices on each axis by at most half a spacing. The spacing is at most
 * RTCCompressionArguments::maxError, or the step between floats on an axis where that is larger. Vertices are compared
 * with the application's floats in long double; no rule of the library is repeated here. */

#include "support/scene.h"
#include "support/surface_access.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace programs::test { namespace {

// --- surfaces ------------------------------------------------------------------------------------

// width x height vertices, row by row, at each time step. Quads lie between neighbors.
struct Sheet {
  unsigned width, height;
  std::vector<std::vector<Vec>> steps;

  size_t quads() const { return size_t(width - 1) * (height - 1); }
};

// Over about [-1,1]^2; it bends and drifts from step to step.
Sheet bumpySheet(unsigned side, unsigned numSteps, double scale = 1, const std::array<double, 3>& offset = {0, 0, 0}) {
  Random random(5);
  Sheet sheet = {side, side, {}};
  std::vector<std::array<double, 3>> jitter(size_t(side) * side);
  for (auto& j : jitter)
    for (double& x : j) x = random.uniform(-0.1, 0.1) * 2 / (side - 1);
  for (unsigned step = 0; step < numSteps; step++) {
    std::vector<Vec> vertices;
    for (unsigned y = 0; y < side; y++)
      for (unsigned x = 0; x < side; x++) {
        const auto& j = jitter[size_t(y) * side + x];
        const double u = 2.0 * x / (side - 1) - 1, v = 2.0 * y / (side - 1) - 1;
        const double p[3] = {u + j[0] + 0.07 * step, v + j[1] - 0.03 * step * u,
                             0.1 * std::sin(7 * u + 3 * v) * std::cos(5 * v) + j[2] + 0.05 * step * v};
        Vec vertex;
        for (int k = 0; k < 3; k++) vertex[k] = float(offset[k] + scale * p[k]);
        vertices.push_back(vertex);
      }
    sheet.steps.push_back(vertices);
  }
  return sheet;
}

enum class Kind { Grids, Quads, Triangles, Cage };
constexpr Kind allKinds[] = {Kind::Grids, Kind::Quads, Kind::Triangles, Kind::Cage};
const char* nameOf(Kind kind) {
  return kind == Kind::Grids ? "grids" : kind == Kind::Quads ? "quads" : kind == Kind::Triangles ? "triangles" : "cage";
}

constexpr unsigned patchQuads = 16; // per side of grids and of faces of the cage, if the sheet is large enough

class Stored {
public:
  Stored(const Sheet& sheet, Kind kind, float maxError, unsigned quadsOfPatch = patchQuads)
    : sheet(sheet),
      kind(kind),
      quadsOfPatch(quadsOfPatch),
      scene(device) {
    const unsigned numSteps = unsigned(sheet.steps.size()), w = sheet.width;
    const RTCGeometryType types[] = {RTC_GEOMETRY_TYPE_GRID, RTC_GEOMETRY_TYPE_QUAD, RTC_GEOMETRY_TYPE_TRIANGLE,
                                     RTC_GEOMETRY_TYPE_SUBDIVISION};
    geometry = rtcNewGeometry(device, types[int(kind)]);
    rtcSetGeometryTimeStepCount(geometry, numSteps);
    for (unsigned step = 0; step < numSteps; step++) {
      const std::vector<Vec> vertices = kind == Kind::Cage ? cageVertices() : sheet.steps[step];
      setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices);
    }
    if (kind == Kind::Grids) {
      std::vector<RTCGrid> grids;
      for (unsigned y = 0; y + 1 < sheet.height; y += quadsOfPatch)
        for (unsigned x = 0; x + 1 < w; x += quadsOfPatch)
          grids.push_back({y * w + x, w, (unsigned short)(quadsOfPatch + 1), (unsigned short)(quadsOfPatch + 1)});
      setBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids);
    } else if (kind == Kind::Cage) {
      std::vector<std::array<unsigned, 4>> faces;
      const unsigned n = patches();
      for (unsigned y = 0; y < n; y++)
        for (unsigned x = 0; x < n; x++) {
          const unsigned corner = y * (n + 1) + x;
          faces.push_back({corner, corner + 1, corner + n + 2, corner + n + 1});
        }
      setBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, std::vector<unsigned>(n * n, 4));
      unsigned* const indices =
          (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, 4 * faces.size());
      std::memcpy(indices, faces.data(), 16 * faces.size());
      rtcSetGeometryTessellationRate(geometry, float(quadsOfPatch));
      rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_PIN_ALL);
      rtcSetGeometryUserData(geometry, this);
      rtcSetGeometryDisplacementFunction(geometry, displace);
    } else if (kind == Kind::Quads) {
      std::vector<std::array<unsigned, 4>> quads;
      forEachQuad([&](unsigned a, unsigned b, unsigned c, unsigned d) { quads.push_back({a, b, d, c}); });
      setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads);
    } else {
      std::vector<std::array<unsigned, 3>> triangles;
      forEachQuad([&](unsigned a, unsigned b, unsigned c, unsigned d) {
        triangles.push_back({a, b, c});
        triangles.push_back({d, c, b});
      });
      setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles);
    }
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = RTC_COMPRESSION_CVERT;
    args.maxError = maxError;
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    rtcCommitScene(scene);
    statistics = statisticsOf(scene);
    error = device.takeError();
  }

  // All vertices at a time step, in the order of the sheet; NaN where none was found. Empty for a mesh that is left
  // to Embree, with its own floats.
  std::vector<Vec> at(unsigned step) {
    if (statistics.numQuads == 0) return {};
    vertices.assign(sheet.steps[0].size(), {NAN, NAN, NAN});
    timeOfStep = sheet.steps.size() > 1 ? float(step) / float(sheet.steps.size() - 1) : 0;
    forEachStoredPart(geometry, timeOfStep, addPart, this);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    return vertices;
  }

  RTCCompressionStatistics statistics;
  RTCError error; // of the commit

private:
  unsigned patches() const { return (sheet.width - 1) / quadsOfPatch; }

  std::vector<Vec> cageVertices() const {
    std::vector<Vec> corners;
    for (unsigned y = 0; y <= patches(); y++)
      for (unsigned x = 0; x <= patches(); x++) corners.push_back({float(x), float(y), 0});
    return corners;
  }

  template<typename Function>
  void forEachQuad(const Function& function) const {
    for (unsigned y = 0; y + 1 < sheet.height; y++)
      for (unsigned x = 0; x + 1 < sheet.width; x++) {
        const unsigned a = y * sheet.width + x;
        function(a, a + 1, a + sheet.width, a + sheet.width + 1);
      }
  }

  size_t indexOf(unsigned primID, float u, float v) const {
    const unsigned x = primID % patches() * quadsOfPatch + unsigned(std::lround(u * float(quadsOfPatch)));
    const unsigned y = primID / patches() * quadsOfPatch + unsigned(std::lround(v * float(quadsOfPatch)));
    return size_t(y) * sheet.width + x;
  }

  // The sheet's floats, so that faces have identical shared vertices.
  static void displace(const RTCDisplacementFunctionNArguments* args) {
    const Stored& self = *(const Stored*)args->geometryUserPtr;
    for (unsigned i = 0; i < args->N; i++) {
      const Vec& p = self.sheet.steps[args->timeStep][self.indexOf(args->primID, args->u[i], args->v[i])];
      args->P_x[i] = p[0];
      args->P_y[i] = p[1];
      args->P_z[i] = p[2];
    }
  }

  static bool addPart(void* ptr, const CbvhPart* part) {
    Stored& self = *(Stored*)ptr;
    if (part->primitivesPerQuad) {
      self.addMeshPart(*part);
      return true;
    }
    for (unsigned i = 0; i < part->width * part->height; i++)
      self.set(self.indexOf(part->primID, part->parameters[2 * i], part->parameters[2 * i + 1]),
               part->vertices + 3 * i);
    return true;
  }

  /* A part of a mesh may be turned and mirrored: neighboring quads show how. Without neighbors, quads are looked up one
   * by one, which is slow. */
  void addMeshPart(const CbvhPart& part) {
    const unsigned w = part.width - 1, h = part.height - 1, columns = sheet.width - 1;
    const auto quadAt = [&](unsigned x, unsigned y) {
      const unsigned quad = part.primIDs[(size_t(y) * w + x) * part.primitivesPerQuad] / part.primitivesPerQuad;
      return std::array<int, 2>{int(quad % columns), int(quad / columns)};
    };
    const auto at = [&](unsigned x, unsigned y) { return part.vertices + 3 * (size_t(y) * part.width + x); };
    const auto first = quadAt(0, 0);
    bool isRegular = w > 1 && h > 1;
    int du[2] = {}, dv[2] = {};
    if (isRegular) {
      for (int k : {0, 1}) {
        du[k] = quadAt(1, 0)[k] - first[k];
        dv[k] = quadAt(0, 1)[k] - first[k];
      }
      isRegular = std::abs(du[0]) + std::abs(du[1]) == 1 && std::abs(dv[0]) + std::abs(dv[1]) == 1 &&
                  du[0] * dv[0] + du[1] * dv[1] == 0;
    }
    for (unsigned y = 0; y < h && isRegular; y++)
      for (unsigned x = 0; x < w && isRegular; x++)
        for (int k : {0, 1}) isRegular &= quadAt(x, y)[k] == first[k] + int(x) * du[k] + int(y) * dv[k];
    if (!isRegular) {
      for (unsigned y = 0; y < h; y++)
        for (unsigned x = 0; x < w; x++) lookUp(unsigned(quadAt(x, y)[0]), unsigned(quadAt(x, y)[1]));
      return;
    }
    for (unsigned y = 0; y < part.height; y++)
      for (unsigned x = 0; x < part.width; x++) {
        int place[2];
        for (int k : {0, 1}) place[k] = (2 * first[k] + 1 + (2 * int(x) - 1) * du[k] + (2 * int(y) - 1) * dv[k]) / 2;
        set(size_t(place[1]) * sheet.width + size_t(place[0]), at(x, y));
      }
  }

  void lookUp(unsigned x, unsigned y) {
    const unsigned quad = y * (sheet.width - 1) + x, a = y * sheet.width + x, b = a + 1, c = a + sheet.width, d = c + 1;
    const unsigned corners[2][3] = {{a, b, c}, {d, c, b}};
    for (unsigned i : {0u, 1u}) {
      CbvhTriangle triangle;
      const float u = kind == Kind::Quads && i ? 0.75f : 0.25f;
      const unsigned primID = kind == Kind::Quads ? quad : 2 * quad + i;
      if (!findStoredTriangle(geometry, timeOfStep, primID, u, u, nullptr, &triangle)) continue;
      for (int k = 0; k < 3; k++) set(corners[i][k], triangle.vertices[k]);
    }
  }

  void set(size_t index, const float* p) {
    Vec& vertex = vertices.at(index);
    EXPECT_TRUE(std::isnan(vertex[0]) || std::equal(p, p + 3, vertex.begin())) << "two positions of vertex " << index;
    std::copy_n(p, 3, vertex.begin());
  }

  const Sheet& sheet;
  const Kind kind;
  const unsigned quadsOfPatch;
  Device device;
  Scene scene;
  RTCGeometry geometry;
  float timeOfStep = 0;
  std::vector<Vec> vertices;
};

// --- promised bounds -------------------------------------------------------------------------------

// From a magnitude to the next float above it.
long double floatStep(float magnitude) {
  return (long double)std::nextafter(magnitude, INFINITY) - (long double)magnitude;
}

typedef std::function<bool(unsigned x, unsigned y)> Exempt; // true for vertices in blocks with an outlier

// Embree, with or without compression, leaves out primitives with a vertex beyond 1.844e18. Rounding may move a
// vertex beyond that limit.
constexpr float largestOfEmbree = 1.8e18f;

// Marks vertices that belong to a quad that Embree does not leave out.
std::vector<bool> vertexIsUsed(const Sheet& sheet) {
  const unsigned w = sheet.width;
  const auto isValid = [&](size_t i) {
    for (const auto& vertices : sheet.steps)
      for (float x : vertices[i])
        if (std::fabs(x) > largestOfEmbree) return false;
    return true;
  };
  std::vector<bool> isUsed(sheet.steps[0].size());
  for (unsigned y = 0; y + 1 < sheet.height; y++)
    for (unsigned x = 0; x + 1 < w; x++) {
      const size_t corners[4] = {size_t(y) * w + x, size_t(y) * w + x + 1, size_t(y + 1) * w + x,
                                 size_t(y + 1) * w + x + 1};
      if (std::all_of(corners, corners + 4, isValid))
        for (size_t i : corners) isUsed[i] = true;
    }
  return isUsed;
}

enum class Expected { Bounds, Lattice }; // Lattice: additionally, the geometry is compressed and some vertex moves

// Measures all vertices at all steps. spacing: requested by maxError, or the default.
void expectBounds(const Sheet& sheet, Kind kind, float spacing, float maxError, Expected expected = Expected::Bounds,
                  unsigned quadsOfPatch = patchQuads, const Exempt& isExempt = nullptr) {
  SCOPED_TRACE(testing::Message() << nameOf(kind) << ", " << sheet.steps.size() << " steps, spacing " << spacing);
  Stored stored(sheet, kind, maxError, quadsOfPatch);
  const std::vector<bool> isUsed = vertexIsUsed(sheet);
  const bool areAllUsed = std::find(isUsed.begin(), isUsed.end(), false) == isUsed.end();
  EXPECT_EQ(stored.error, kind == Kind::Cage && !areAllUsed ? RTC_ERROR_INVALID_ARGUMENT : RTC_ERROR_NONE);
  const auto isCounted = [&](size_t i) {
    return isUsed[i] && !(isExempt && isExempt(unsigned(i % sheet.width), unsigned(i / sheet.width)));
  };
  long double allowed[3] = {}, most[3] = {}, mostDistance = 0;
  for (int k = 0; k < 3; k++) {
    float magnitude = 0;
    for (const auto& vertices : sheet.steps)
      for (size_t i = 0; i < vertices.size(); i++)
        if (isCounted(i)) magnitude = std::max(magnitude, std::fabs(vertices[i][k]));
    allowed[k] = std::max((long double)spacing, floatStep(magnitude)) / 2;
  }
  size_t missing = 0;
  for (unsigned step = 0; step < sheet.steps.size(); step++) {
    const std::vector<Vec> found = stored.at(step);
    if (found.empty()) continue;
    for (size_t i = 0; i < found.size(); i++) {
      long double square = 0;
      if (!(std::isfinite(found[i][0]) && std::isfinite(found[i][1]) && std::isfinite(found[i][2]))) {
        missing += isUsed[i];
        continue;
      }
      for (int k = 0; k < 3; k++) {
        const long double moved = std::fabs((long double)found[i][k] - (long double)sheet.steps[step][i][k]);
        if (isCounted(i)) most[k] = std::max(most[k], moved);
        square += moved * moved;
      }
      mostDistance = std::max(mostDistance, std::sqrt(square));
    }
  }
  EXPECT_EQ(missing, 0u);
  for (int k = 0; k < 3; k++)
    EXPECT_LE(double(most[k] / allowed[k]), 1) << "of half a spacing, on axis " << "xyz"[k] << ", where a spacing of "
                                               << double(2 * allowed[k]) << " is allowed";
  if (expected == Expected::Lattice) {
    EXPECT_EQ(stored.statistics.numQuads, sheet.quads()) << "compressed";
    EXPECT_GT(most[0] + most[1] + most[2], 0) << "on a lattice";
  }

  /* the statistics report what was measured, rounded to a float */
  const long double reported = stored.statistics.maxVertexDeviation;
  EXPECT_GE(reported, mostDistance * (1 - 4 * (long double)FLT_EPSILON)) << "maxVertexDeviation";
  if (areAllUsed) {
    EXPECT_LE(reported, mostDistance * (1 + 16 * (long double)FLT_EPSILON) + std::numeric_limits<float>::denorm_min())
        << "maxVertexDeviation";
  }
}

std::string nameOfCase(const testing::TestParamInfo<Kind>& info) { return nameOf(info.param); }

class VertexBounds : public testing::TestWithParam<Kind> {};

// --- the cases --------------------------------------------------------------------------------------

// Spacings from a quad's edge down to 1/2187 of it.
TEST_P(VertexBounds, HoldForAllSpacings) {
  for (unsigned numSteps : {1u, 3u}) {
    const Sheet sheet = bumpySheet(33, numSteps);
    for (double part = 1; part < 5000; part *= 3) {
      const float spacing = float(0.0625 / part);
      expectBounds(sheet, GetParam(), spacing, spacing, part > 2 && part < 100 ? Expected::Lattice : Expected::Bounds);
    }
  }
}

TEST_P(VertexBounds, HoldForTheDefaultSpacing) {
  for (unsigned numSteps : {1u, 3u})
    for (double scale : {1.0, 3e-5, 7e4}) {
      const Sheet sheet = bumpySheet(33, numSteps, scale);
      double longest = 0;
      for (const auto& vertices : sheet.steps)
        for (size_t i = 0; i + sheet.width < vertices.size(); i++) {
          double square = 0;
          const Vec &a = vertices[i], &b = vertices[i + sheet.width];
          for (int k = 0; k < 3; k++) square += std::pow(double(b[k]) - double(a[k]), 2);
          longest = std::max(longest, std::sqrt(square));
        }
      // vertices of an application are stored more accurately
      const double part = GetParam() == Kind::Cage ? 36 : GetParam() == Kind::Grids ? 512 : 2048;
      expectBounds(sheet, GetParam(), float(longest / part), -1, Expected::Lattice);
    }
}

TEST_P(VertexBounds, HoldAtEveryScale) {
  for (unsigned numSteps : {1u, 3u})
    for (int decade = -30; decade <= 30; decade++) {
      SCOPED_TRACE(testing::Message() << "scale 1e" << decade);
      const double scale = std::pow(10.0, decade);
      const float spacing = float(scale * 0.001);
      expectBounds(bumpySheet(33, numSteps, scale), GetParam(), spacing, spacing,
                   std::abs(decade) < 18 ? Expected::Lattice : Expected::Bounds);
    }
}

// An axis far from the origin does not coarsen the others.
TEST_P(VertexBounds, HoldFarFromTheOrigin) {
  for (unsigned numSteps : {1u, 3u})
    for (double distance : {528980.0, -4.5e6, 1e7, 1e12})
      for (unsigned axes = 1; axes < 8; axes++) {
        SCOPED_TRACE(testing::Message() << distance << " along " << (axes & 1 ? "x" : "") << (axes & 2 ? "y" : "")
                                        << (axes & 4 ? "z" : ""));
        const std::array<double, 3> offset = {axes & 1 ? distance : 0, axes & 2 ? distance : 0,
                                              axes & 4 ? distance : 0};
        for (float spacing : {0.001f, 1.0f})
          expectBounds(bumpySheet(33, numSteps, 1000 * double(spacing), offset), GetParam(), spacing, spacing);
      }
}

// As on a national grid: easting and northing are large, heights are not.
TEST_P(VertexBounds, HoldOnANationalGrid) {
  for (const auto& corner : {std::array<double, 3>{528980, 183526, 40}, std::array<double, 3>{4.5e6, 5.4e6, 300}})
    for (float spacing : {0.01f, 0.05f}) expectBounds(bumpySheet(33, 1, 33, corner), GetParam(), spacing, spacing);
}

INSTANTIATE_TEST_SUITE_P(Kinds, VertexBounds, testing::ValuesIn(allKinds), nameOfCase);

// --- outliers -------------------------------------------------------------------------------------------

// Vertices more than 16 quads away from the outlier, along either side, are in other blocks.
Exempt nearTo(unsigned x0, unsigned y0) {
  const auto areNear = [](unsigned a, unsigned b) { return std::max(a, b) - std::min(a, b) <= 16; };
  return [=](unsigned x, unsigned y) { return areNear(x, x0) && areNear(y, y0); };
}

// The outlier is inside a block, between blocks, and on a patch's border and corner. quadsOfPatch: 16 or all; not used
// for meshes.
void expectBoundsNextToOutlier(Kind kind, unsigned side, unsigned quadsOfPatch, unsigned numSteps) {
  const Sheet sheet = bumpySheet(side, numSteps);
  const float spacing = 2.0f / float(side - 1) / 20;
  for (const std::array<unsigned, 2>& at : {std::array<unsigned, 2>{267, 133}, {256, 133}, {side - 1, 133}, {0, 0}})
    for (float distance : {1e6f, -1e7f, 1e30f}) {
      const unsigned axes = distance == 1e6f ? 7 : 4;
      SCOPED_TRACE(testing::Message() << side << " x " << side << " vertices, that at (" << at[0] << "," << at[1]
                                      << ") is " << distance << (axes == 7 ? " along all axes" : " along z"));
      Sheet withOutlier = sheet;
      for (int k = 0; k < 3; k++)
        if (axes >> k & 1) withOutlier.steps.back()[size_t(at[1]) * side + at[0]][k] = distance;
      expectBounds(withOutlier, kind, spacing, spacing, Expected::Lattice, quadsOfPatch, nearTo(at[0], at[1]));
    }
}

TEST(VertexBoundsNextToAnOutlier, OneGrid) { expectBoundsNextToOutlier(Kind::Grids, 321, 320, 1); }
TEST(VertexBoundsNextToAnOutlier, ManyGrids) { expectBoundsNextToOutlier(Kind::Grids, 321, 16, 1); }
TEST(VertexBoundsNextToAnOutlier, MovingGrids) { expectBoundsNextToOutlier(Kind::Grids, 321, 320, 2); }
TEST(VertexBoundsNextToAnOutlier, Quads) { expectBoundsNextToOutlier(Kind::Quads, 321, 0, 1); }
TEST(VertexBoundsNextToAnOutlier, Triangles) { expectBoundsNextToOutlier(Kind::Triangles, 321, 0, 1); }
TEST(VertexBoundsNextToAnOutlier, Cage) { expectBoundsNextToOutlier(Kind::Cage, 321, 320, 1); }

TEST(VertexBoundsNextToAnOutlier, AMillionVertices) {
  const unsigned side = 1001;
  Sheet sheet = bumpySheet(side, 1);
  sheet.steps[0][size_t(500) * side + 700][2] = 1e7f;
  expectBounds(sheet, Kind::Grids, 1e-4f, 1e-4f, Expected::Lattice, 1000, nearTo(700, 500));
}

}} // namespace programs::test
