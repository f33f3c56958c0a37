// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "all_hits.h"
#include "hits.h"
#include "interruptible.h"
#include "ray_arrays.h"

#include "basics/parallel.h"
#include "tracing/ray_conversion.h"

#include <algorithm>
#include <optional>
#include <tuple>

namespace programs::python {
namespace {

/* The filter finds it by its first member. */
struct Collection {
  RTCIntersectContext context;
  std::vector<RTCRayHit>* hits;
};

void collectAndReject(const RTCFilterFunctionNArguments* arguments) {
  RTCRayHit hit;
  hit.ray = rtcGetRayFromRayN(arguments->ray, arguments->N, 0);
  hit.hit = rtcGetHitFromHitN(arguments->hit, arguments->N, 0);
  reinterpret_cast<Collection*>(arguments->context)->hits->push_back(hit);
  arguments->valid[0] = 0;
}

auto orderOf(const RTCRayHit& h) { return std::tuple(h.ray.tfar, h.hit.geomID, h.hit.primID, h.hit.u, h.hit.v); }

} // namespace

void findAllHits(RTCScene scene, const Ray& ray, std::vector<RTCRayHit>& hits) {
  hits.clear();
  Collection collection;
  rtcInitIntersectContext(&collection.context);
  collection.context.filter = collectAndReject;
  collection.hits = &hits;
  RTCRayHit traced;
  load(ray, traced);
  rtcIntersect1(scene, &collection.context, &traced);
  std::sort(hits.begin(), hits.end(), [](const RTCRayHit& a, const RTCRayHit& b) { return orderOf(a) < orderOf(b); });
}

/* --- for arrays of rays ------------------------------------------------------------ */

namespace {

constexpr size_t chunk = 1024; // rays per task

/* Hits of a task's rays, in order. */
struct TaskHits {
  std::vector<SurfaceHit> hits;
  std::vector<size_t> ends; // for each ray, the number of hits up to its last one
};

TaskHits traceTask(const TracedScene& scene, const RayArrays& rays, size_t begin, size_t end, size_t maxHits) {
  const FlushDenormals denormals;
  TaskHits result;
  std::vector<RTCRayHit> ofRay;
  for (size_t i = begin; i < end; i++) {
    findAllHits(scene.handle(), rays.ray(i), ofRay);
    ofRay.resize(std::min(ofRay.size(), maxHits));
    for (const RTCRayHit& hit : ofRay) result.hits.push_back(scene.surfaceHit(hit));
    result.ends.push_back(result.hits.size());
  }
  return result;
}

py::tuple allHits(const Scene& scene, const py::object& origins, const py::object& directions, const py::object& tnear,
                  const py::object& tfar, const py::object& time, std::optional<long long> maxHits, int threads) {
  scene.requireSearchable("finding all hits");
  const RayArrays rays = readRays(origins, directions, tnear, tfar, time);
  if (maxHits && *maxHits < 0)
    throwValueError("max_hits", "is " + std::to_string(*maxHits) + ": expected 0 or more, or None");
  const size_t most = maxHits ? size_t(*maxHits) : SIZE_MAX;

  std::vector<TaskHits> tasks((rays.count + chunk - 1) / chunk);
  runQuery(rays.count, chunk, threadsOf(threads), [&](unsigned n) {
    parallelFor(rays.count, chunk, n, [&](size_t begin, size_t end) {
      tasks[begin / chunk] = traceTask(scene.traced(), rays, begin, end, most);
    });
    scene.checkRays();
  });

  size_t count = 0;
  for (const TaskHits& task : tasks) count += task.hits.size();
  auto hits = std::make_shared<Hits>(Hits{{py::ssize_t(count)}, LargeArray<SurfaceHit>(count), scene.faces()});
  py::array_t<int64_t> raysOfHits(hits->shape);
  SurfaceHit* hit = hits->hits.data();
  int64_t* rayOfHit = raysOfHits.mutable_data();
  int64_t ray = 0;
  for (TaskHits& task : tasks) {
    hit = std::copy(task.hits.begin(), task.hits.end(), hit);
    size_t begin = 0;
    for (const size_t end : task.ends) {
      rayOfHit = std::fill_n(rayOfHit, end - begin, ray++);
      begin = end;
    }
    task = TaskHits(); // needs no memory any more
  }
  return py::make_tuple(hits, raysOfHits);
}

constexpr const char* allHitsText = R"(Finds all hits of each ray.

Returns two results for the hits of all rays, ray by ray in C order, and along each ray by distance: Hits of shape (m,);
and (m,) int64, the index of each hit's ray. A ray through an edge or a vertex may hit several of its triangles, each of
which counts.

max_hits: most hits per ray, the closest ones; None for all.

Other arguments and errors as in intersect. Only for ctile and cvert; raises Error for other representations.)";

} // namespace

void defineAllHits(py::class_<Scene, std::shared_ptr<Scene>>& scene) {
  using py::arg;
  const py::float_ zero(0.0), infinity(INFINITY);
  scene.def("all_hits", &allHits, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
            py::kw_only(), arg("time") = zero, arg("max_hits") = py::none(), arg("threads") = 0, allHitsText);
}

} // namespace programs::python
