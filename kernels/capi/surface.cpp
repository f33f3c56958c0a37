// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface.h"
#include "points.h"
#include "structs.h"

#include "cbvh/base/number_text.h"
#include "cbvh/operations/device.h"
#include "cbvh/operations/dicing.h"
#include "cbvh/operations/stored_surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

using namespace embree::capi;
namespace core = embree::core;
using embree::numberText;

namespace {

constexpr unsigned int maxSteps = 129;             // RTC_MAX_TIME_STEP_COUNT
constexpr size_t maxSharedBytes = size_t(1) << 34; // Embree's limit for vertices of grids and meshes

/* Copies an array of the application into a new buffer of a geometry, without gaps. size: bytes per item. Of vertices
 * and attributes, Embree reads 16 bytes, beyond the last one, too: its asserts require numbers there. */
void copyTo(RTCGeometry geometry, RTCBufferType type, unsigned int slot, RTCFormat format, const void* data,
            size_t size, size_t stride, size_t count) {
  if (count == 0) return;
  char* const to = (char*)rtcSetNewGeometryBuffer(geometry, type, slot, format, size, count);
  if (!to) return; // the device reports the error
  if (stride == size) std::memcpy(to, data, size * count);
  else
    for (size_t i = 0; i < count; i++) std::memcpy(to + i * size, (const char*)data + i * stride, size);
  if (type == RTC_BUFFER_TYPE_VERTEX || type == RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE)
    std::memset(to + size * count, 0, 16 - sizeof(float)); // Embree allocates buffers with 16 more bytes
}

template<typename T>
void copyTo(RTCGeometry geometry, RTCBufferType type, unsigned int slot, RTCFormat format, const T* data,
            size_t count) {
  copyTo(geometry, type, slot, format, data, sizeof(T), sizeof(T), count);
}

/* Embree rounds corners of any finite sharpness. */
void copySharpness(RTCGeometry geometry, RTCBufferType type, const float* values, size_t count) {
  constexpr float infinite = 10; // as in OpenSubdiv and USD
  std::vector<float> sharpness(values, values + count);
  for (float& s : sharpness)
    if (s >= infinite) s = INFINITY;
  copyTo(geometry, type, 0, RTC_FORMAT_FLOAT, sharpness.data(), count);
}

void displace(const RTCDisplacementFunctionNArguments* args) {
  const Input& input = *(const Input*)args->geometryUserPtr;
  const CbvhDisplacementArguments publicArgs = {input.displacementUserPtr,
                                                args->primID,
                                                args->timeStep,
                                                args->u,
                                                args->v,
                                                args->Ng_x,
                                                args->Ng_y,
                                                args->Ng_z,
                                                args->P_x,
                                                args->P_y,
                                                args->P_z,
                                                args->N};
  const ErrorScope errors;
  input.displacement(&publicArgs);
}

RTCSubdivisionMode modeOf(CbvhBoundary boundary) {
  switch (boundary) {
  case CBVH_BOUNDARY_SMOOTH: return RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY;
  case CBVH_BOUNDARY_PIN_CORNERS: return RTC_SUBDIVISION_MODE_PIN_CORNERS;
  case CBVH_BOUNDARY_PIN_BOUNDARY: return RTC_SUBDIVISION_MODE_PIN_BOUNDARY;
  case CBVH_BOUNDARY_PIN_ALL: return RTC_SUBDIVISION_MODE_PIN_ALL;
  }
  throwInvalidArgument("invalid boundary " + std::to_string(int(boundary)) + ": expected 0 to 3, see CbvhBoundary");
}

bool reportProgress(void* self, double done) {
  const Input& input = *(const Input*)self;
  if (!input.progress) return true;
  const ErrorScope errors;
  return input.progress(input.progressPtr, done) != 0;
}

std::string describeItem(const char* item, size_t i, const char* verb, size_t value) {
  return std::string(item) + " " + std::to_string(i) + " " + verb + " " + std::to_string(value);
}

/* Throws if a value is not below `bound`, for example "crease index 3 is vertex 9: the cage has 8 vertices", with the
 * item "crease index", the target "vertex" and the targets "vertices". */
void checkBelow(const unsigned int* values, size_t count, size_t bound, const char* item, const char* target,
                const char* targets) {
  for (size_t i = 0; i < count; i++)
    if (values[i] >= bound)
      throwInvalidArgument(std::string(item) + " " + std::to_string(i) + " is " + target + " " +
                           std::to_string(values[i]) + ": the cage has " + std::to_string(bound) + " " + targets);
}

void checkSharpness(const float* values, size_t count, const char* array) {
  for (size_t i = 0; i < count; i++)
    if (!(values[i] >= 0))
      throwInvalidArgument(std::string(array) + " " + std::to_string(i) + " is " + numberText(values[i]) +
                           ": expected 0 to infinity");
}

/* Throws if there are no vertices, a face has fewer than 3, not all indices are used, a sharpness is invalid, or an
 * index or count would make Embree access memory outside of buffers. */
void checkTopology(const CbvhCage& cage) {
  require(cage.vertices.numVertices > 0, "there are no vertices");
  size_t sum = 0;
  for (size_t f = 0; f < cage.numFaces; f++) {
    if (cage.faceVertexCounts[f] < 3)
      throwInvalidArgument(describeItem("face", f, "has", cage.faceVertexCounts[f]) + " vertices: expected 3 or more");
    sum += cage.faceVertexCounts[f];
    if (sum > cage.numIndices)
      throwInvalidArgument(describeItem("face", f, "ends at index", sum) + ", but there are " +
                           std::to_string(cage.numIndices) + " indices");
  }
  if (sum != cage.numIndices)
    throwInvalidArgument("the faces have " + std::to_string(sum) + " vertices together, but there are " +
                         std::to_string(cage.numIndices) + " indices: expected as many");
  checkBelow(cage.indices, cage.numIndices, cage.vertices.numVertices, "index", "vertex", "vertices");
  checkBelow(cage.creases, 2 * cage.numCreases, cage.vertices.numVertices, "crease index", "vertex", "vertices");
  checkBelow(cage.corners, cage.numCorners, cage.vertices.numVertices, "corner", "vertex", "vertices");
  checkBelow(cage.holes, cage.numHoles, cage.numFaces, "hole", "face", "faces");
  checkSharpness(cage.creaseSharpness, cage.numCreases, "creaseSharpness");
  checkSharpness(cage.cornerSharpness, cage.numCorners, "cornerSharpness");
}

} // namespace

/* Faces without four corners have a sub-patch per corner. In sub-patch i + 4 j, u is 2 i + 0.5 to 2 i + 1.5, and v is
 * 2 j + 0.5 to 2 j + 1.5. Parameters up to 0.5 outside of it are accepted. Requires a cage with attributes: others have
 * no nonQuads. */
void Input::checkParameters(unsigned int primID, float u, float v) const {
  if (primID >= numPrimitives)
    throwInvalidArgument("invalid primID " + std::to_string(primID) + ": the surface has " +
                         std::to_string(numPrimitives) + " faces");
  const auto reject = [&](const std::string& why) {
    throwInvalidArgument("u " + numberText(u) + ", v " + numberText(v) + " of face " + std::to_string(primID) + ": " +
                         why);
  };
  const auto other = std::lower_bound(nonQuads.begin(), nonQuads.end(), std::make_pair(primID, 0u));
  if (other == nonQuads.end() || other->first != primID) {
    const float tolerance = 1e-3f; // because parameters of hits are rounded
    if (!(u >= -tolerance && u <= 1 + tolerance && v >= -tolerance && v <= 1 + tolerance)) reject("expected 0 to 1");
    return;
  }
  const unsigned int corners = other->second, maxCorners = 16; // Embree does not tessellate faces with more
  if (corners > maxCorners)
    reject("the face has " + std::to_string(corners) + " corners and is left out: expected a face of 16 or fewer");
  if (!(u >= 0 && u < 8 && v >= 0 && v < 8) || unsigned(u / 2) + 4 * unsigned(v / 2) >= corners)
    reject("expected one of its " + std::to_string(corners) + " sub-patches, as hits number them");
}

void Input::checkAttribute(unsigned int attribute) const {
  if (attribute >= widths.size())
    throwInvalidArgument("invalid attribute " + std::to_string(attribute) + ": the surface has " +
                         std::to_string(widths.size()) + " attributes");
}

CbvhSurfaceTy::CbvhSurfaceTy(CbvhContext context, RTCGeometry geometry) : context(context), isReference(true) {
  rtcRetainGeometry(geometry); // first: an input that cannot be stored releases it
  current.reset(new Input(geometry));
}

unsigned int CbvhSurfaceTy::numPrimitives() const {
  if (isReference) return core::numPrimitives(current->embreeGeometry());
  const Input* const latest = pending ? pending.get() : current.get();
  return latest ? latest->numPrimitives : 0;
}

CbvhSurfaceTy::ChangeScope::ChangeScope(CbvhSurfaceTy& surface) : surface(surface) {
  if (surface.isReference)
    throw Failure{CBVH_ERROR_INVALID_OPERATION,
                  "the surface refers to a geometry: change and commit it with functions of rtcore.h"};
  if (surface.isChanging.exchange(true))
    throw Failure{
        CBVH_ERROR_INVALID_OPERATION,
        "the surface is being changed, committed or diced: its callbacks, and other threads, must not change it"};
}

void CbvhSurfaceTy::setVertices(RTCGeometry geometry, const CbvhVertices& vertices, bool copies) {
  require(vertices.steps && vertices.numVertices > 0, "there are no vertices");
  if (vertices.stride < 12 || vertices.stride % 4 != 0)
    throwInvalidArgument("invalid stride of vertices, " + std::to_string(vertices.stride) +
                         " bytes: expected a multiple of 4, at least 12");
  if (vertices.numVertices > 0xFFFFFFFFu)
    throwInvalidArgument("too many vertices, " + std::to_string(vertices.numVertices) +
                         ": expected at most 4294967295");
  if (!copies && vertices.numVertices > maxSharedBytes / vertices.stride)
    throwInvalidArgument("too many vertices, " + std::to_string(vertices.numVertices) + " with a stride of " +
                         std::to_string(vertices.stride) + " bytes: expected at most 16 GiB per time step");
  if (vertices.numSteps < 1 || vertices.numSteps > maxSteps)
    throwInvalidArgument("invalid number of time steps " + std::to_string(vertices.numSteps) + ": expected 1 to " +
                         std::to_string(maxSteps));
  rtcSetGeometryTimeStepCount(geometry, vertices.numSteps);
  if (vertices.numSteps > 1) {
    if (!(vertices.startTime < vertices.endTime && std::isfinite(vertices.endTime - vertices.startTime)))
      throwInvalidArgument("invalid time range " + numberText(vertices.startTime) + " to " +
                           numberText(vertices.endTime) +
                           ": expected finite times, startTime < endTime and a finite difference");
    rtcSetGeometryTimeRange(geometry, vertices.startTime, vertices.endTime);
  }
  for (unsigned int i = 0; i < vertices.numSteps; i++) {
    if (!vertices.steps[i]) throwInvalidArgument("the vertices of time step " + std::to_string(i) + " are NULL");
    if (copies)
      copyTo(geometry, RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3, vertices.steps[i], 12, vertices.stride,
             vertices.numVertices);
    else
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3, vertices.steps[i], 0,
                                 vertices.stride, vertices.numVertices);
  }
}

void CbvhSurfaceTy::setPending(InputPtr input) {
  context->check();
  pending = std::move(input);
}

void CbvhSurfaceTy::set(const CbvhCage& cage) {
  const ChangeScope change(*this);
  require(cage.numFaces > 0 && cage.faceVertexCounts && cage.indices, "the cage has no faces, or no indices");
  require(cage.numFaces < 0xFFFFFFFFu && cage.numIndices < 0xFFFFFFFFu,
          "too many faces or indices: expected fewer than 4294967295 of each");
  const size_t numRates = cage.rates ? cage.numIndices : 1;
  const float* const rates = cage.rates ? cage.rates : &cage.rate;
  for (size_t i = 0; i < numRates; i++)
    if (!(rates[i] >= 1 && rates[i] <= 4096))
      throwInvalidArgument("invalid rate " + numberText(rates[i]) +
                           (cage.rates ? " at index " + std::to_string(i) : "") + ": expected 1 to 4096");
  require(cage.numCreases == 0 || (cage.creases && cage.creaseSharpness),
          "creases or creaseSharpness is NULL, but numCreases is not 0");
  require(cage.numCorners == 0 || (cage.corners && cage.cornerSharpness),
          "corners or cornerSharpness is NULL, but numCorners is not 0");
  require(cage.numHoles == 0 || cage.holes, "holes is NULL, but numHoles is not 0");
  require(cage.numAttributes == 0 || cage.attributes, "attributes is NULL, but numAttributes is not 0");
  checkTopology(cage);

  InputPtr input(new Input(context->device, RTC_GEOMETRY_TYPE_SUBDIVISION));
  const RTCGeometry geometry = input->geometry;
  input->numPrimitives = unsigned(cage.numFaces);
  input->numIndices = cage.numIndices;
  for (size_t f = 0; cage.numAttributes && f < cage.numFaces; f++)
    if (cage.faceVertexCounts[f] != 4) input->nonQuads.emplace_back(unsigned(f), cage.faceVertexCounts[f]);
  setVertices(geometry, cage.vertices, true);
  copyTo(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, cage.faceVertexCounts, cage.numFaces);
  copyTo(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, cage.indices, cage.numIndices);
  if (cage.rates) copyTo(geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, cage.rates, cage.numIndices);
  else rtcSetGeometryTessellationRate(geometry, cage.rate);
  copyTo(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2, cage.creases, 8, 8, cage.numCreases);
  copySharpness(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, cage.creaseSharpness, cage.numCreases);
  copyTo(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, 0, RTC_FORMAT_UINT, cage.corners, cage.numCorners);
  copySharpness(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, cage.cornerSharpness, cage.numCorners);
  copyTo(geometry, RTC_BUFFER_TYPE_HOLE, 0, RTC_FORMAT_UINT, cage.holes, cage.numHoles);
  rtcSetGeometrySubdivisionMode(geometry, 0, modeOf(cage.boundary));
  if (cage.displacement) {
    input->displacement = cage.displacement;
    input->displacementUserPtr = cage.displacementUserPtr;
    rtcSetGeometryUserData(geometry, input.get());
    rtcSetGeometryDisplacementFunction(geometry, displace);
  }

  unsigned int topologies = 1;
  for (size_t i = 0; i < cage.numAttributes; i++) topologies += cage.attributes[i].indices != nullptr;
  rtcSetGeometryTopologyCount(geometry, topologies);
  rtcSetGeometryVertexAttributeCount(geometry, unsigned(cage.numAttributes));
  unsigned int topology = 0;
  for (size_t i = 0; i < cage.numAttributes; i++) {
    const CbvhAttribute& attribute = cage.attributes[i];
    const std::string name = "attribute " + std::to_string(i);
    if (!attribute.values || attribute.numValues == 0) throwInvalidArgument(name + " has no values");
    if (attribute.width < 1 || attribute.width > 16 || attribute.stride < 4 * attribute.width ||
        attribute.stride % 4 != 0)
      throwInvalidArgument(name + " has width " + std::to_string(attribute.width) + " and stride " +
                           std::to_string(attribute.stride) +
                           ": expected a width of 1 to 16, and a stride of at least 4*width that is "
                           "a multiple of 4 bytes");
    const unsigned int* const indices = attribute.indices ? attribute.indices : cage.indices;
    for (size_t k = 0; k < cage.numIndices; k++)
      if (indices[k] >= attribute.numValues)
        throwInvalidArgument("index " + std::to_string(k) + " of " + name + " is " + std::to_string(indices[k]) +
                             ": the attribute has " + std::to_string(attribute.numValues) + " values");
    copyTo(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, unsigned(i), RTCFormat(RTC_FORMAT_FLOAT + attribute.width - 1),
           attribute.values, 4 * attribute.width, attribute.stride, attribute.numValues);
    input->widths.push_back(attribute.width);
    if (!attribute.indices) continue;
    topology++;
    copyTo(geometry, RTC_BUFFER_TYPE_INDEX, topology, RTC_FORMAT_UINT, attribute.indices, cage.numIndices);
    rtcSetGeometrySubdivisionMode(geometry, topology, modeOf(attribute.boundary));
    rtcSetGeometryVertexAttributeTopology(geometry, unsigned(i), topology);
  }
  setPending(std::move(input));
}

void CbvhSurfaceTy::set(const CbvhGrids& grids) {
  const ChangeScope change(*this);
  require(grids.numGrids > 0 && grids.grids, "there are no grids");
  require(grids.numGrids < 0xFFFFFFFFu, "too many grids: expected fewer than 4294967295");
  InputPtr input(new Input(context->device, RTC_GEOMETRY_TYPE_GRID));
  static_assert(sizeof(CbvhGrid) == sizeof(RTCGrid), "CbvhGrid must have the layout of RTCGrid");
  input->numPrimitives = unsigned(grids.numGrids);
  setVertices(input->geometry, grids.vertices, false);
  copyTo(input->geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids.grids, grids.numGrids);
  setPending(std::move(input));
}

void CbvhSurfaceTy::set(const CbvhMesh& mesh) {
  const ChangeScope change(*this);
  if (mesh.verticesPerFace != 3 && mesh.verticesPerFace != 4)
    throwInvalidArgument("invalid verticesPerFace " + std::to_string(mesh.verticesPerFace) + ": expected 3 or 4");
  require(mesh.numFaces > 0 && mesh.indices, "the mesh has no indices");
  require(mesh.numFaces < 0xFFFFFFFFu, "too many faces of a mesh: expected fewer than 4294967295");
  const bool hasQuads = mesh.verticesPerFace == 4;
  InputPtr input(new Input(context->device, hasQuads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE));
  input->numPrimitives = unsigned(mesh.numFaces);
  setVertices(input->geometry, mesh.vertices, false);
  copyTo(input->geometry, RTC_BUFFER_TYPE_INDEX, 0, hasQuads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3, mesh.indices,
         4 * mesh.verticesPerFace, 4 * mesh.verticesPerFace, mesh.numFaces);
  setPending(std::move(input));
}

namespace {

struct ScopedFlag {
  explicit ScopedFlag(std::atomic<bool>& flag) : flag(flag) { flag = true; }
  ~ScopedFlag() { flag = false; }
  std::atomic<bool>& flag;
};

} // namespace

void CbvhSurfaceTy::dice(const CbvhDicingArguments& dicing, float* rates) {
  if (isReference) {
    const std::vector<float> levels = core::dice(current->embreeGeometry(), cameraOf(dicing));
    if (rates) std::copy(levels.begin(), levels.end(), rates);
    return;
  }
  const ChangeScope change(*this);
  if (!pending || !pending->numIndices)
    throw Failure{CBVH_ERROR_INVALID_OPERATION,
                  "there is no cage to dice: call cbvhSetSurfaceCage first, also after a commit"};
  const ScopedFlag scope(isPendingInUse);
  embree::CompressionSettings none; // so that the settings of the context do not compress and release the cage
  none.compression = RTC_COMPRESSION_NONE;
  core::setCompression(pending->embreeGeometry(), none);
  rtcCommitGeometry(pending->geometry); // computes the topology; commit() selects compression later
  context->check();
  const std::vector<float> levels = core::dice(pending->embreeGeometry(), cameraOf(dicing));
  if (rates) std::copy(levels.begin(), levels.end(), rates);
}

void CbvhSurfaceTy::set(const CbvhAccuracy& newAccuracy) {
  const ChangeScope change(*this);
  if (!(std::isfinite(newAccuracy.maxError) && newAccuracy.maxError >= 0))
    throwInvalidArgument("maxError " + numberText(newAccuracy.maxError) +
                         " is negative or not finite: expected at least 0");
  core::validate(settingsOf(newAccuracy, false));
  accuracy = newAccuracy;
}

void CbvhSurfaceTy::setLossless(bool lossless) {
  const ChangeScope change(*this);
  isLossless = lossless;
}

void CbvhSurfaceTy::setMask(unsigned int newMask) {
  const ChangeScope change(*this);
  mask = newMask;
}

void CbvhSurfaceTy::applyMask() {
  if (mask == appliedMask) return;
  const ChangeScope change(*this);
  rtcSetGeometryMask(current->geometry, mask);
  rtcCommitGeometry(current->geometry);
  context->check();
  appliedMask = mask;
}

void CbvhSurfaceTy::commit(CbvhProgressFunction progress, void* userPtr) {
  const ChangeScope change(*this);
  if (!pending) {
    if (!current)
      throw Failure{CBVH_ERROR_INVALID_OPERATION, "the surface has no cage, grids or mesh: set one of them first"};
    if (!core::selectSameBlocks(settingsOf(accuracy, isLossless), committedSettings))
      throw Failure{CBVH_ERROR_INVALID_OPERATION,
                    "the accuracy was changed after the surface released its input: set the cage, grids or mesh again"};
    return;
  }
  /* Removes the callback. If commitInput() threw and left the input pending, also removes its request for compression.
   * The current input must stay unmodified, because groups cannot commit a modified geometry. */
  struct Restore {
    const CbvhSurfaceTy& surface;
    const std::shared_ptr<Input> input;

    ~Restore() {
      input->progress = nullptr;
      if (surface.pending != input) return;
      try {
        core::setCompression(input->embreeGeometry(), embree::CompressionSettings());
      } catch (...) {}
    }
  } restore = {*this, pending};
  pending->progress = progress;
  pending->progressPtr = userPtr;
  commitInput();
}

embree::CompressionSettings CbvhSurfaceTy::settingsOf(const CbvhAccuracy& accuracy, bool isLossless) const {
  embree::CompressionSettings settings;
  settings.compression = core::exactCompression((embree::Device*)context->device);
  settings.releasesInput = true;
  settings.storesSmallMeshes = true; // the application may have no other way to trace them
  settings.warnsOfFaces = false;     // cbvhCommitGroup reports them
  if (isLossless) {
    settings.maxError = 0; // ignores the accuracy
    return settings;
  }
  if (accuracy.maxError > 0) settings.maxError = accuracy.maxError;
  settings.maxPixelError = accuracy.maxPixelError;
  std::copy_n(accuracy.cameraPosition, 3, settings.cameraPosition);
  settings.pixelSize = accuracy.pixelSize;
  return settings;
}

void CbvhSurfaceTy::commitInput() {
  embree::CompressionSettings settings = settingsOf(accuracy, isLossless);
  if (pending->progress) {
    settings.progress = reportProgress;
    settings.progressUserPtr = pending.get();
  }
  core::setCompression(pending->embreeGeometry(), settings);
  rtcSetGeometryMask(pending->geometry, mask);
  {
    const ScopedFlag scope(isPendingInUse);
    rtcCommitGeometry(pending->geometry);
  }
  /* If Embree reports an error although it stored the blocks, the input becomes the current one before the error is
   * thrown. */
  const Failure failure = context->takeError();
  if (!core::hasBlocks(pending->embreeGeometry())) {
    if (failure) throw failure;
    const char* const why = core::reasonNotCompressed(pending->embreeGeometry());
    if (!why) throw Failure{CBVH_ERROR_INVALID_OPERATION, "the surface is not stored"};
    throw Failure{CBVH_ERROR_INVALID_OPERATION, std::string("the mesh is not stored: its quads or triangles ") + why};
  }
  current = std::move(pending);
  committedSettings = settings;
  appliedMask = mask;
  if (failure) throw failure;
}

void CbvhSurfaceTy::load(const core::CompressedFile& file, size_t index) {
  current.reset(new Input((RTCGeometry)file.load(index)));
  current->numPrimitives = file.geometryInfo(index).numPrimitives;
}

std::shared_ptr<const Input> CbvhSurfaceTy::committedInput() const {
  if (!current)
    throw Failure{CBVH_ERROR_INVALID_OPERATION, "the surface is not committed: call cbvhCommitSurface first"};
  return current;
}

std::shared_ptr<const Input> CbvhSurfaceTy::interpolationInput() const {
  return isPendingInUse ? pending : committedInput();
}

/* --- the API --------------------------------------------------------------------------- */

CbvhError cbvhNewSurface(CbvhContext context, CbvhSurface* surface) {
  if (!context || !surface) return rejectArgument("context or surface is NULL");
  return guarded(context, [&] { *surface = new CbvhSurfaceTy(context); });
}
void cbvhRetainSurface(CbvhSurface surface) {
  if (surface) surface->retain();
}
void cbvhReleaseSurface(CbvhSurface surface) {
  if (surface) surface->release();
}

namespace {

template<typename Closure>
CbvhError onSurface(CbvhSurface surface, const Closure& closure) {
  if (!surface) return rejectArgument("surface is NULL");
  const RefPtr<CbvhSurfaceTy> held(surface); // callbacks may release the application's references
  return guarded(surface->context.get(), closure);
}

/* Calls closure with a struct that was converted to the current version. */
template<typename T, typename Closure>
CbvhError withStruct(CbvhSurface surface, const T* from, const char* name, const Closure& closure) {
  return onSurface(surface, [&] {
    if (!from) throwInvalidArgument(std::string(name) + " is NULL");
    closure(core::readStruct(from));
  });
}

} // namespace

CbvhError cbvhSetSurfaceCage(CbvhSurface surface, const CbvhCage* cage) {
  return withStruct(surface, cage, "cage", [&](const CbvhCage& converted) { surface->set(converted); });
}

CbvhError cbvhSetSurfaceGrids(CbvhSurface surface, const CbvhGrids* grids) {
  return withStruct(surface, grids, "grids", [&](const CbvhGrids& converted) { surface->set(converted); });
}

CbvhError cbvhSetSurfaceMesh(CbvhSurface surface, const CbvhMesh* mesh) {
  return withStruct(surface, mesh, "mesh", [&](const CbvhMesh& converted) { surface->set(converted); });
}

CbvhError cbvhDiceSurface(CbvhSurface surface, const CbvhDicingArguments* dicing, float* rates) {
  return withStruct(surface, dicing, "dicing",
                    [&](const CbvhDicingArguments& converted) { surface->dice(converted, rates); });
}

CbvhError cbvhSetSurfaceAccuracy(CbvhSurface surface, const CbvhAccuracy* accuracy) {
  return onSurface(surface, [&] { surface->set(accuracy ? core::readStruct(accuracy) : CbvhAccuracy()); });
}

CbvhError cbvhSetSurfaceLossless(CbvhSurface surface, int lossless) {
  return onSurface(surface, [&] { surface->setLossless(lossless != 0); });
}

CbvhError cbvhSetSurfaceMask(CbvhSurface surface, unsigned int mask) {
  return onSurface(surface, [&] { surface->setMask(mask); });
}

CbvhError cbvhCommitSurface(CbvhSurface surface, CbvhProgressFunction progress, void* userPtr) {
  return onSurface(surface, [&] { surface->commit(progress, userPtr); });
}

unsigned int cbvhGetSurfacePrimitiveCount(CbvhSurface surface) { return surface ? surface->numPrimitives() : 0; }

CbvhError cbvhInterpolateAttribute(CbvhSurface surface, unsigned int primID, float u, float v, unsigned int attribute,
                                   float* P, float* dPdu, float* dPdv) {
  return onSurface(surface, [&] {
    const std::shared_ptr<const Input> input = surface->interpolationInput();
    input->checkAttribute(attribute);
    input->checkParameters(primID, u, v);
    rtcInterpolate1(input->geometry, primID, u, v, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, attribute, P, dPdu, dPdv,
                    input->widths[attribute]);
    surface->context->check();
  });
}

CbvhError cbvhInterpolateAttributeAtPoints(CbvhSurface surface, const CbvhInterpolationPoints* interpolation) {
  return withStruct(surface, interpolation, "points", [&](const CbvhInterpolationPoints& points) {
    require(points.count == 0 || (points.u && points.v), "u or v is NULL");
    const std::shared_ptr<const Input> input = surface->interpolationInput();
    input->checkAttribute(points.attribute);
    const unsigned int width = input->widths[points.attribute];
    for (size_t i = 0; i < points.count; i++) input->checkParameters(points.primID, points.u[i], points.v[i]);
    const auto at = [&](float* out, size_t i) { return out ? out + i * width : nullptr; };
    for (size_t i = 0; i < points.count; i++)
      rtcInterpolate1(input->geometry, points.primID, points.u[i], points.v[i], RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE,
                      points.attribute, at(points.P, i), at(points.dPdu, i), at(points.dPdv, i), width);
    surface->context->check();
  });
}

int cbvhFindTriangle(CbvhSurface surface, float time, unsigned int primID, float u, float v, const float* Ng,
                     CbvhTriangle* triangle) {
  bool isFound = false;
  onSurface(surface, [&] {
    require(triangle, "triangle is NULL");
    embree::cbvh::StoredTriangle stored;
    isFound = core::findTriangle(surface->committedInput()->embreeGeometry(), time, primID, u, v, Ng, stored);
    if (isFound) *triangle = toPublic(stored);
  });
  return isFound;
}

int cbvhFindClosestPoint(CbvhSurface surface, float time, unsigned int primID, const float p[3], float radius,
                         CbvhClosestPoint* closest) {
  bool isFound = false;
  onSurface(surface, [&] {
    require(p && closest, "p or closest is NULL");
    checkPoint(p, radius);
    embree::cbvh::PointOnSurface found;
    isFound =
        core::findClosestPointOfPrimitive(surface->committedInput()->embreeGeometry(), time, primID, p, radius, found);
    if (isFound) *closest = toPublic(found);
  });
  return isFound;
}

CbvhError cbvhForEachPart(CbvhSurface surface, float time, CbvhPartFunction function, void* userPtr) {
  return onSurface(surface, [&] {
    require(function, "function is NULL");
    const std::shared_ptr<const Input> input = surface->committedInput();
    core::forEachPart(input->embreeGeometry(), time, [&](const embree::cbvh::StoredPart& part) {
      const ErrorScope errors;
      const CbvhPart publicPart = toPublic(part);
      return function(userPtr, &publicPart) != 0;
    });
  });
}

CbvhError cbvhForEachCluster(CbvhSurface surface, float time, CbvhClusterFormat format, CbvhClusterFunction function,
                             void* userPtr, CbvhClusterStatistics* statistics) {
  return onSurface(surface, [&] {
    if (statistics) core::requireStruct(statistics);
    const std::shared_ptr<const Input> input = surface->committedInput();
    int value; // memcpy, because a value outside of the enumeration would be undefined behavior
    std::memcpy(&value, &format, sizeof(value));
    embree::cbvh::ClusterStatistics sums;
    const auto finish = [&] {
      if (statistics) core::writeStruct(statistics, embree::cbvh::statisticsAs<CbvhClusterStatistics>(sums));
    };
    try {
      core::forEachCluster(
          input->embreeGeometry(), time, embree::cbvh::ClusterFormat(value),
          [&](const embree::cbvh::StoredCluster& cluster) {
            if (!function) return true;
            const ErrorScope errors;
            const CbvhPart part = toPublic(*cluster.part);
            const CbvhCluster publicCluster = embree::cbvh::clusterAs<CbvhCluster>(cluster, part);
            return function(userPtr, &publicCluster) != 0;
          },
          sums);
    } catch (...) {
      finish();
      throw;
    } // statistics of the clusters before the error
    finish();
  });
}
