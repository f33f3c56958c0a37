// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "dicing.h"
#include "../base/number_text.h"
#include "../embree/isolated_tasks.h"
#include "../files/loaded_geometry.h"
#include "../surface/dicing_samples.h"
#include "../surface/input_checks.h"
#include "../surface/patches.h"

namespace embree::core {
namespace {
void requireFinite(const char* name, const float* values, size_t n) {
  for (size_t i = 0; i < n; i++)
    if (!std::isfinite(values[i]))
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                     std::string("invalid ") + name + ": " + numberText(values[i]) + " is not finite");
}

/*! Throws unless the value is finite and above the bound or, with orEqual, not below it. bound: 0 or 1. */
void requireAbove(const char* name, float value, float bound, bool orEqual) {
  if (!std::isfinite(value) || !(orEqual ? value >= bound : value > bound))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, std::string("invalid ") + name + " " + numberText(value) +
                                                   ": expected " + (orEqual ? "at least " : "more than ") +
                                                   (bound == 1.0f ? "1" : "0"));
}

void validate(const DicingCamera& camera, size_t numEdges) {
  requireFinite("position", camera.position, 3);
  requireAbove("pixelSize", camera.pixelSize, 0.0f, false);
  requireAbove("width", camera.width, 0.0f, true);
  requireAbove("height", camera.height, 0.0f, true);
  requireAbove("quadSize", camera.quadSize, 0.0f, false);
  requireAbove("outsideFactor", camera.outsideFactor, 1.0f, true);
  if (!(camera.maxRate >= 1.0f && camera.maxRate <= 4096.0f))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                   "invalid maxRate " + numberText(camera.maxRate) + ": expected 1 to 4096");
  if (camera.transform) requireFinite("transform", camera.transform, 12);
  if (camera.maxRates)
    for (size_t i = 0; i < numEdges; i++)
      if (!(camera.maxRates[i] >= 1.0f))
        throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, "invalid maxRates: " + numberText(camera.maxRates[i]) +
                                                       " at index " + std::to_string(i) + ": expected at least 1");
  if (!(camera.width > 0.0f && camera.height > 0.0f)) return;
  requireFinite("direction", camera.direction, 3);
  requireFinite("up", camera.up, 3);
  const Double3 direction = {camera.direction[0], camera.direction[1], camera.direction[2]},
                up = {camera.up[0], camera.up[1], camera.up[2]};
  /* the sine of the angle between them must exceed 1e-7, about the precision of floats */
  const double lengths2 = dot(direction, direction) * dot(up, up);
  const double right2 = dot(cross(direction, up), cross(direction, up));
  if (!(right2 > 1e-14 * lengths2))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                   "invalid direction or up: expected vectors that are not zero and not parallel");
}

/*! Sets each edge's rate to the highest of its faces. rates: one per index. */
void equalizeEdgeRates(const SubdivMesh* mesh, std::vector<float>& rates) {
  struct Edge {
    uint64_t vertices;
    uint32_t index;
    bool operator<(const Edge& e) const { return vertices < e.vertices; }
  };
  const BufferView<unsigned>& indices = mesh->topology[0].vertexIndices;
  std::vector<Edge> edges(rates.size());
  for (size_t f = 0, e = 0; f < mesh->numFaces(); f++) {
    const unsigned n = mesh->faceVertices[f];
    for (unsigned i = 0; i < n; i++) {
      const uint64_t a = indices[e + i], b = indices[e + (i + 1) % n];
      edges[e + i] = Edge{min(a, b) << 32 | max(a, b), uint32_t(e + i)};
    }
    e += n;
  }
  std::sort(edges.begin(), edges.end());
  for (size_t i = 0, j; i < edges.size(); i = j) {
    float highest = 1.0f;
    for (j = i; j < edges.size() && edges[j].vertices == edges[i].vertices; j++)
      highest = max(highest, rates[edges[j].index]);
    for (size_t k = i; k < j; k++) rates[edges[k].index] = highest;
  }
}

/*! Largest power of two up to `bound` and 4096. bound: at least 1, may be infinite. */
float largestRate(float bound) { return std::ldexp(1.0f, std::ilogb(min(bound, 4096.0f))); } // log2 would round up

/*! Nearest power of two by ratio, at most `bound`. */
float roundedRate(float rate, float bound) {
  return min(std::ldexp(1.0f, int(std::lround(std::log2(max(rate, 1.0f))))), largestRate(bound));
}

/*! Measures all faces at all time steps. Returns one rate per index. */
std::vector<float> measureRates(SubdivMesh* mesh, const DicingCamera& camera) {
  const DicingView view(camera);
  std::vector<uint32_t> first(mesh->numFaces());
  uint32_t edges = 0;
  for (size_t f = 0; f < first.size(); f++) {
    first[f] = edges;
    edges += mesh->faceVertices[f];
  }
  std::vector<float> rates(mesh->numEdges(), 1.0f);
  parallel_for(size_t(0), mesh->numFaces(), size_t(16), [&](const range<size_t>& r) {
    DicingSamples samples(mesh, view);
    for (size_t f = r.begin(); f != r.end(); f++) {
      const unsigned n = mesh->faceVertices[f];
      if (!isa::canBeEvaluated(mesh->getHalfEdge(0, f), n)) continue; // commits leave out such faces
      float* const out = &rates[first[f]];
      for (unsigned step = 0; step < mesh->numTimeSteps; step++) {
        float quads[4];
        if (!mesh->valid(f, step)) continue;
        if (n == 4) {
          samples.measure(unsigned(f), step, 0.0f, 0.0f, quads);
          for (int i = 0; i < 4; i++) out[i] = max(out[i], quads[i]);
        }
        /* Otherwise the face has a patch per corner i, whose parameters begin at u = 2 (i % 4) + 0.5 and
         * v = 2 (i / 4) + 0.5. The sides v = 0 and u = 0 are halves of the edges after and before corner i,
         * so an edge needs twice the quads of its half. The opposite sides count for the same edges. Embree
         * supports at most 16 corners. */
        else
          for (unsigned i = 0; i < min(n, 16u); i++) {
            samples.measure(unsigned(f), step, 0.5f + 2.0f * float(i % 4), 0.5f + 2.0f * float(i / 4), quads);
            float &ahead = out[i], &behind = out[(i + n - 1) % n];
            ahead = max(ahead, 2.0f * max(quads[0], quads[2]));
            behind = max(behind, 2.0f * max(quads[1], quads[3]));
          }
      }
      // Bounds the rates of this face only; afterwards an edge gets the highest rate of its faces. Bounds are
      // powers of two, so that rounding cannot exceed them.
      if (camera.maxRates)
        for (unsigned i = 0; i < n; i++) out[i] = min(out[i], largestRate(camera.maxRates[first[f] + i]));
    }
  });
  equalizeEdgeRates(mesh, rates);
  for (float& rate : rates) rate = roundedRate(rate, camera.maxRate);
  return rates;
}
} // namespace

std::vector<float> dice(Geometry* geometry, const DicingCamera& camera) {
  const CompressibleGeometry* const compressible = asCompressible(geometry);
  if (!compressible || compressible->ownType != Geometry::GTY_SUBDIV_MESH)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, "only subdivision surfaces can be diced");
  requireEditable(geometry);
  SubdivMesh* const mesh = (SubdivMesh*)geometry;
  requireBuffer(geometry, mesh->vertices[0].getPtr());
  if (Geometry::State(geometry->state) != Geometry::State::COMMITTED ||
      mesh->topology[0].halfEdges.size() < mesh->numEdges() || !mesh->vertices[0])
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry must be committed before it is diced");
  std::vector<float> rates;
  runIsolated([&] {
    checkIndices(mesh); // commits of uncompressed geometry do not check them
    validate(camera, mesh->numEdges());
    rates = measureRates(mesh, camera);
  });
  Ref<Buffer> levelBuffer = new Buffer(geometry->device, rates.size() * sizeof(float));
  std::copy(rates.begin(), rates.end(), (float*)levelBuffer->data());
  geometry->setBuffer(RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, levelBuffer, 0, sizeof(float),
                      unsigned(rates.size()));
  return rates;
}
} // namespace embree::core
