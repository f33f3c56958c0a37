// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Random edits of geometries that scenes share, while another scene is traced. After every third edit, on average, a
 * scene must have the hits of newly created geometries: no block may belong to an earlier state.
 *
 * CBVH_EDITS sets the number of edits, CBVH_EDITS_SEED the seed. */

#include "support/memory.h"
#include "support/scene.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <map>
#include <memory>
#include <thread>

namespace programs::test { namespace {

unsigned numberIn(const char* variable, unsigned otherwise) {
  const char* text = std::getenv(variable);
  return text ? unsigned(std::strtoul(text, nullptr, 10)) : otherwise;
}

const RTCCompression kinds[] = {RTC_COMPRESSION_CVERT,  RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF,
                                RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CGRID, RTC_COMPRESSION_NONE};

class EditedSurface {
public:
  EditedSurface(RTCDevice device, const Cage& cage) : device(device), cage(cage) {
    settings.rate = 4;
    settings.displacement = &displacement;
    settings.compression = RTC_COMPRESSION_CVERT;
    geometry = newSurface(device, cage, settings);
  }
  ~EditedSurface() { rtcReleaseGeometry(geometry); }
  EditedSurface(const EditedSurface&) = delete;

  // Returns a new geometry in the current state.
  RTCGeometry newTwin() const {
    RTCGeometry twin = newSurface(device, cage, settings);
    if (!isEnabled) rtcDisableGeometry(twin);
    return twin;
  }

  // Updates everything if the input was released, otherwise only the changes.
  void edit(Random& random) {
    const bool isReleased = hasReleased;
    switch (random.below(13)) {
    case 0: { // one vertex, which may become NaN and finite again
      const size_t i = random.below(unsigned(cage.positions.size()));
      for (float& x : cage.positions[i])
        x = random.chance(0.05) ? NAN : std::isfinite(x) ? x + float(0.1 * random.normal()) : float(random.normal());
      if (isReleased) break;
      float* vertices = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
      std::copy(cage.positions[i].begin(), cage.positions[i].end(), vertices + 3 * i);
      rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
      break;
    }
    case 1:
      settings.rate = float(1 + random.below(8));
      rtcSetGeometryTessellationRate(geometry, settings.rate);
      break;
    case 2: // the behavior of the displacement function, not its address
      displacement.amplitude = float(0.1 * random.uniform());
      rtcSetGeometryDisplacementFunction(geometry, Displacement::apply);
      break;
    case 3:
      settings.edgeRates.assign(cage.indices.size(), 1.0f);
      for (float& rate : settings.edgeRates) rate = float(1 + random.below(8));
      if (!isReleased) setBuffer(geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, settings.edgeRates);
      break;
    case 4:
      cage.corners = {random.below(unsigned(cage.positions.size()))};
      cage.cornerWeights = {float(4 * random.uniform())};
      if (!isReleased) setCorners();
      break;
    case 5:
      settings.mask = random.below(2) ? ~0u : 2u;
      rtcSetGeometryMask(geometry, settings.mask);
      if (isReleased) {
        rtcCommitGeometry(geometry);
        return;
      }
      break;
    case 6:
      isEnabled = !isEnabled;
      if (isEnabled) rtcEnableGeometry(geometry);
      else rtcDisableGeometry(geometry);
      if (isReleased) {
        rtcCommitGeometry(geometry);
        return;
      }
      break;
    case 7:
      settings.compression = kinds[random.below(6)];
      setCompression(false);
      break;
    case 8: // no change
      break;
    case 9: {
      const unsigned i = random.below(unsigned(cage.indices.size() - 1));
      cage.creases = {{cage.indices[i], cage.indices[i + 1]}};
      cage.creaseWeights = {float(3 * random.uniform())};
      if (!isReleased) setCreases();
      break;
    }
    case 10: {
      const RTCSubdivisionMode modes[] = {RTC_SUBDIVISION_MODE_NO_BOUNDARY, RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY,
                                          RTC_SUBDIVISION_MODE_PIN_CORNERS, RTC_SUBDIVISION_MODE_PIN_BOUNDARY,
                                          RTC_SUBDIVISION_MODE_PIN_ALL};
      cage.mode = modes[random.below(5)];
      rtcSetGeometrySubdivisionMode(geometry, 0, cage.mode);
      break;
    }
    case 11:
      cage.holes = {random.below(unsigned(cage.faces.size()))};
      if (!isReleased) setHoles();
      break;
    case 12: setCompression(true); break;
    }
    if (isReleased) setInput();
    rtcCommitGeometry(geometry);
    hasReleased = asksForRelease && settings.compression != RTC_COMPRESSION_NONE;
  }

  RTCGeometry geometry;

private:
  void setCompression(bool releases) {
    asksForRelease = releases;
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = settings.compression;
    args.fallbackFaces = settings.fallbackFaces;
    if (releases) args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
    rtcSetGeometryCompression(geometry, &args);
  }

  void setCorners() {
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, 0, RTC_FORMAT_UINT, cage.corners);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, cage.cornerWeights);
  }

  void setCreases() {
    setBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2, cage.creases);
    setBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, cage.creaseWeights);
  }

  void setHoles() { setBuffer(geometry, RTC_BUFFER_TYPE_HOLE, 0, RTC_FORMAT_UINT, cage.holes); }

  void setInput() {
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, cage.positions);
    setBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, cage.faces);
    setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, cage.indices);
    setBuffer(geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, settings.edgeRates);
    setCorners();
    setCreases();
    setHoles();
  }

  RTCDevice device;
  Cage cage;
  Displacement displacement;
  SurfaceSettings settings;
  bool isEnabled = true, asksForRelease = false, hasReleased = false;
};

void expectTwins(RTCScene scene, RTCScene twin, Random& random, unsigned rays, size_t& hits) {
  for (RTCRayHit ray : raysAt(random, rays, 1.2f)) {
    ray.ray.mask = random.below(2) ? ~0u : 1u;
    const RTCRayHit a = intersect(scene, ray), b = intersect(twin, ray);
    ASSERT_EQ(std::memcmp(&a, &b, sizeof(a)), 0)
        << "geometries " << int(a.hit.geomID) << " " << int(b.hit.geomID) << ", faces " << int(a.hit.primID) << " "
        << int(b.hit.primID) << ", distances " << a.ray.tfar << " " << b.ray.tfar;
    hits += isHit(a);
    ASSERT_EQ(occluded(scene, ray), occluded(twin, ray));
  }
}

class Bystander {
public:
  Bystander(RTCDevice device, unsigned seed) : scene(device, prismCage(5), settings()) {
    Random random(seed);
    rays = raysAt(random, 200);
    for (const RTCRayHit& ray : rays) hits.push_back(intersect(scene, ray));
    thread = std::thread([this] {
      while (!ends)
        for (size_t i = 0; i < rays.size() && !ends; i++) {
          const RTCRayHit hit = intersect(scene, rays[i]);
          if (std::memcmp(&hit, &hits[i], sizeof(hit)) != 0) different++;
        }
    });
  }
  ~Bystander() {
    ends = true;
    thread.join();
    EXPECT_EQ(different, 0u);
  }

private:
  static SurfaceSettings settings() {
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    return settings;
  }

  SurfaceScene scene;
  std::vector<RTCRayHit> rays, hits;
  std::atomic<bool> ends{false};
  std::atomic<size_t> different{0};
  std::thread thread;
};

TEST(GeometryEdits, ScenesMatchFreshTwins) {
  const unsigned numEdits = numberIn("CBVH_EDITS", 1500), seed = numberIn("CBVH_EDITS_SEED", 1);
  Memory memory;
  {
    Device device;
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Bystander bystander(device, seed);
    Random random(seed);
    size_t hits = 0;
    const Cage cages[] = {cubeCage(), sheetCage(1), sheetCage(3), prismCage(3), trapezohedronCage(4)};
    std::vector<std::unique_ptr<EditedSurface>> surfaces;
    for (const Cage& cage : cages) surfaces.emplace_back(new EditedSurface(device, cage));
    struct {
      std::unique_ptr<Scene> scene;
      std::map<unsigned, EditedSurface*> surfaces;
    } scenes[3];
    for (auto& s : scenes) s.scene.reset(new Scene(device, RTC_SCENE_FLAG_ROBUST));

    for (unsigned i = 0; i < numEdits; i++) {
      SCOPED_TRACE(testing::Message() << "edit " << i << ", CBVH_EDITS_SEED=" << seed);
      auto& s = scenes[random.below(3)];
      std::unique_ptr<EditedSurface>& surface = surfaces[random.below(unsigned(surfaces.size()))];
      switch (random.below(8)) {
      case 0: {
        const unsigned id = random.below(8);
        for (auto it = s.surfaces.begin(); it != s.surfaces.end();) {
          if (it->first != id && it->second != surface.get()) {
            ++it;
            continue;
          }
          rtcDetachGeometry(*s.scene, it->first);
          it = s.surfaces.erase(it);
        }
        rtcAttachGeometryByID(*s.scene, surface->geometry, id);
        s.surfaces[id] = surface.get();
        break;
      }
      case 1:
        if (s.surfaces.empty()) break;
        rtcDetachGeometry(*s.scene, s.surfaces.begin()->first);
        s.surfaces.erase(s.surfaces.begin());
        break;
      case 2:
        if (random.below(8)) break;
        s.scene.reset(new Scene(device));
        s.surfaces.clear();
        break;
      case 3: { // replaced by a new geometry, which no scene contains yet
        if (random.below(8)) break;
        for (auto& other : scenes)
          for (auto it = other.surfaces.begin(); it != other.surfaces.end();) {
            if (it->second != surface.get()) {
              ++it;
              continue;
            }
            rtcDetachGeometry(*other.scene, it->first);
            it = other.surfaces.erase(it);
          }
        surface.reset(new EditedSurface(device, cages[random.below(5)]));
        break;
      }
      default: surface->edit(random);
      }
      if (random.below(3)) continue;
      rtcCommitScene(*s.scene);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      Scene twin(device, rtcGetSceneFlags(*s.scene));
      for (const auto& attached : s.surfaces) {
        RTCGeometry geometry = attached.second->newTwin();
        rtcAttachGeometryByID(twin, geometry, attached.first);
        rtcReleaseGeometry(geometry);
      }
      rtcCommitScene(twin);
      expectTwins(*s.scene, twin, random, 100, hits);
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_GT(hits, numEdits / 2);
  }
  EXPECT_EQ(memory.live, 0);
}

}} // namespace programs::test
