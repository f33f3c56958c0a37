// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The commit of a geometry that can be compressed: beginCommit() runs before Embree reads the input, endCommit()
 * afterwards (settings/compressible_geometry.h). The next commit of a scene builds the blocks (building/builder.cpp),
 * unless endCommit() has. */

#include "interpolation_checks.h"
#include "../base/environment.h"
#include "../blocks/surface_blocks.h"
#include "../surface/cage_memory.h"
#include "../surface/embree_bytes.h"
#include "../surface/input_checks.h"
#include "../surface/mesh_regions.h"
#include "../surface/plan.h"
#include <new>
#include <set>

namespace embree {
DECLARE_ISA_FUNCTION(void, buildBlocksOfGeometry, CompressibleGeometry*);

namespace {
struct Symbols {
  DEFINE_ISA_FUNCTION(void, buildBlocksOfGeometry, CompressibleGeometry*);

  explicit Symbols(int features) { SELECT_SYMBOL_DEFAULT_AVX(features, buildBlocksOfGeometry); }
};

/*! Runs a closure like the commit of a scene: with denormals as zero, so that both build the same vertices, and not
 *  canceled with the application's tasks. */
template<typename Closure>
void runAsCommit(const Closure& closure) {
  struct DenormalsAsZero {
    const unsigned int before;
    DenormalsAsZero() : before(_mm_getcsr()) { _mm_setcsr(before | /* FTZ */ (1 << 15) | /* DAZ */ (1 << 6)); }
    ~DenormalsAsZero() { _mm_setcsr(before); }
  } denormalsAsZero;
#if defined(TASKING_INTERNAL)
  Ref<TaskScheduler> scheduler = new TaskScheduler;
  scheduler->spawn_root(closure, 1, true);
#else
  runIsolated(closure);
#endif
}

/*! Marks a geometry while its commit builds blocks. The application's displacement and progress functions must not
 *  commit it then, because that would replace input that is being read. */
class BuildScope {
public:
  explicit BuildScope(const Geometry* geometry) : geometry(geometry) {
    Lock<MutexSys> lock(mutex());
    all().insert(geometry);
  }
  ~BuildScope() {
    Lock<MutexSys> lock(mutex());
    all().erase(geometry);
  }
  BuildScope(const BuildScope&) = delete;
  BuildScope& operator=(const BuildScope&) = delete;

  static void requireNotBuilding(const Geometry* geometry) {
    Lock<MutexSys> lock(mutex());
    if (all().count(geometry))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                     "the geometry is being committed: its callbacks, and other threads, must not commit it");
  }

private:
  /* Never destroyed, because destructors of static objects may commit geometries. */
  static MutexSys& mutex() {
    static MutexSys& it = *new MutexSys;
    return it;
  }
  static std::set<const Geometry*>& all() {
    static std::set<const Geometry*>& it = *new std::set<const Geometry*>;
    return it;
  }

  const Geometry* const geometry;
};

/*! True if geometries of a type inherit the compression of the device. */
bool inheritsCompression(const CompressionSettings& device, Geometry::GType type) {
  switch (type) {
  case Geometry::GTY_GRID_MESH: return device.compressesGrids;
  case Geometry::GTY_QUAD_MESH: return device.compressesQuads;
  case Geometry::GTY_TRIANGLE_MESH: return device.compressesTriangles;
  default: return true;
  }
}

bool requestsCompression(const CompressibleGeometry* geometry) {
  const CompressionSettings& device = geometry->device->compression;
  if (geometry->compression.compression == RTC_COMPRESSION_INHERIT && !inheritsCompression(device, geometry->ownType))
    return false;
  return geometry->compression.resolve(device).compression != RTC_COMPRESSION_NONE;
}

const char* const inputWasReleased =
    "the input of the geometry was released when it was compressed (RTC_COMPRESSION_FLAG_RELEASE_INPUT, "
    "cbvh_release_input in the device string, or release_input in EMBREE_CBVH)";

bool releasesInput(const CompressibleGeometry* geometry) {
  return geometry->compression.resolve(geometry->device->compression).releasesInput;
}

/*! Discards the blocks, and returns true, unless they remain valid (SurfaceState::areBlocksValid). Throws if the
 *  input was released and is not set again, or if another commit of the geometry builds blocks. missing: names of
 *  the input, for the message. */
bool discardOutdatedBlocks(CompressibleGeometry* geometry, bool hasInput, const char* missing) {
  BuildScope::requireNotBuilding(geometry);
  SurfaceState& surface = geometry->surface;
  if (surface.areBlocksValid(geometry->modCounter_)) return false;
  if (surface.inputReleased && !hasInput)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                   std::string(inputWasReleased) + ": set " + missing + " again before it is committed");
  surface.inputReleased = false;
  surface.blocks.reset();
  std::atomic_store(&surface.regions, std::shared_ptr<const QuadRegions>());
  return true;
}

/*! Estimates whether blocks need no more memory than Embree's own grids. */
bool areSmallerAsBlocks(const GridMesh* mesh) {
  const bool isWide = hasWideNodes(mesh->device);
  const auto sumOf = [&](const range<size_t>& r) {
    GridBytes sum;
    for (size_t i = r.begin(); i != r.end(); i++)
      sum = sum + bytesOfGrid(mesh->grid(i).resX, mesh->grid(i).resY, mesh->numTimeSteps, isWide);
    return sum;
  };
  return parallel_reduce(size_t(0), mesh->grids.size(), size_t(1) << 14, GridBytes(), sumOf, std::plus<GridBytes>())
      .areBlocksSmaller();
}

/*! Meshes with fewer primitives stay uncompressed unless storesSmallMeshes is set: Embree's own structures need at
 *  most about 20 KiB for them. */
const size_t minPrimitives = 256;

/*! Prints at verbosity 1, or if EMBREE_CBVH contains "verbose". */
void printCommitLine(const CompressibleGeometry* geometry, const std::string& what) {
  if (!geometry->device->verbosity(1) && !environmentRequestsCommitLines()) return;
  Lock<MutexSys> lock(g_printMutex);
  std::cerr << "compression: " << what << std::endl;
}

void printWarnings(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return;
  Lock<MutexSys> lock(g_printMutex);
  for (const std::string& warning : warnings) std::cerr << "compression: " << warning << std::endl;
}

/*! True if a buffer changed since the last commit that describeIgnoredInput() reads. */
bool isTopologyModified(const SubdivMesh* mesh) {
  return mesh->faceVertices.isLocalModified() || mesh->topology[0].vertexIndices.isLocalModified() ||
         mesh->edge_creases.isLocalModified() || mesh->edge_crease_weights.isLocalModified() ||
         mesh->vertex_creases.isLocalModified() || mesh->vertex_crease_weights.isLocalModified() ||
         mesh->levels.isLocalModified();
}

/*! Marks a geometry as compressed if isRequested and rejectionReason is null. Stores and prints why a request is
 *  rejected. The reason completes "not compressed: 12 quads that ..."; it is not printed if empty. primitives:
 *  their name, plural. */
void setDecision(CompressibleGeometry* geometry, bool isRequested, const char* rejectionReason,
                 const char* primitives) {
  geometry->setCompressed(isRequested && !rejectionReason);
  geometry->surface.rejectionReason = isRequested ? rejectionReason : nullptr;
  if (isRequested && rejectionReason && *rejectionReason)
    printCommitLine(geometry, "not compressed: " + std::to_string(geometry->size()) + " " + primitives + " that " +
                                  rejectionReason);
}

/*! Ends the commit of the SurfaceState. If the geometry is compressed, must release its input and has no blocks,
 *  builds them and returns true: the caller must then release the input. */
bool buildBlocksNow(CompressibleGeometry* geometry) {
  geometry->surface.commit(geometry->modCounter_);
  const bool isOfTree =
      geometry->isCompressed() || (geometry->numTimeSteps == 1 && geometry->ownType == Geometry::GTY_SUBDIV_MESH);
  if (!releasesInput(geometry) || geometry->surface.blocks || !isOfTree || !requestsCompression(geometry)) return false;
  const Symbols symbols(geometry->device->enabled_builder_cpu_features);
  const BuildScope scope(geometry);
  runAsCommit([&] { symbols.buildBlocksOfGeometry(geometry); });
  geometry->surface.inputReleased = true;
  return true;
}
} // namespace

static bool beginCommitOf(SubdivMesh* mesh) {
  const bool hasInput = mesh->vertices[0] && mesh->faceVertices && mesh->topology[0].vertexIndices;
  if (!discardOutdatedBlocks(mesh, hasInput, "vertices, faces and indices")) return false;
  const bool isRequested = requestsCompression(mesh), moves = mesh->numTimeSteps != 1;
  if (isRequested) {
    checkIndices(mesh);
    if (isTopologyModified(mesh)) printWarnings(describeIgnoredInput(mesh));
  } else if (std::any_of(mesh->topology.begin(), mesh->topology.end(),
                         [](const SubdivMesh::Topology& t) { return bool(t.vertexIndices); }))
    checkSizes(mesh);
  setDecision(mesh, isRequested && moves,
              isa::CompressionPlan::compressesMotion(mesh) ? nullptr
                                                           : "have motion blur, which requires fallback_faces=1",
              "faces");
  CageMemory::reserveHalfEdges(mesh);
  return true;
}

static bool beginCommitOf(GridMesh* mesh) {
  if (!discardOutdatedBlocks(mesh, mesh->vertices[0] && mesh->grids, "vertices and grids")) return false;
  const bool isRequested = requestsCompression(mesh);
  if (isRequested) checkTimeSteps(mesh);
  if (isRequested) checkStrides(mesh);
  const char* const rejectionReason = !releasesInput(mesh) && isRequested && !areSmallerAsBlocks(mesh)
                                          ? "are so small that Embree's own kernel needs less memory for them"
                                          : nullptr;
  setDecision(mesh, isRequested, rejectionReason, "grids");
  if (!mesh->isCompressed()) checkSides(mesh);
  return true;
}

/*! As divideMesh(). If memory runs out, the next commit of the scene reports it (regionsOf), because programs do not
 *  expect the commit of a geometry to fail. */
template<typename Mesh>
static std::shared_ptr<const QuadRegions> tryDivideMesh(Mesh* mesh) {
  try {
    return divideMesh(mesh);
  } catch (const std::bad_alloc&) {}
  std::shared_ptr<QuadRegions> none = std::make_shared<QuadRegions>();
  none->isOutOfMemory = true;
  return none;
}

/*! Triangles of mesh blocks are numbered by 32 bits, and a quad has two. */
static bool hasTooManyTriangles(const QuadMesh* mesh) { return mesh->size() > size_t(1) << 31; }
static bool hasTooManyTriangles(const TriangleMesh*) { return false; }

template<typename Mesh>
static bool beginCommitOfMesh(Mesh* mesh, bool hasInput, const char* primitives) {
  if (!discardOutdatedBlocks(mesh, hasInput, "vertices and indices")) return false;
  const bool isRequested = requestsCompression(mesh);
  if (isRequested && hasInput) checkTimeSteps(mesh);
  const char* rejectionReason = !hasInput || mesh->size() == 0             ? ""
                                : mesh->quality == RTC_BUILD_QUALITY_REFIT ? "have RTC_BUILD_QUALITY_REFIT"
                                : mesh->size() < minPrimitives && !mesh->compression.storesSmallMeshes
                                    ? "are too few to matter"
                                : hasTooManyTriangles(mesh) ? "are too many: expected at most 2147483648"
                                                            : nullptr;
  if (isRequested && !rejectionReason) {
    const std::shared_ptr<const QuadRegions> regions = tryDivideMesh(mesh);
    std::atomic_store(&mesh->surface.regions, regions);
    if (regions->numInvalid)
      printCommitLine(mesh, std::to_string(regions->numInvalid) + " of " + std::to_string(mesh->size()) + " " +
                                primitives + " are left out because an index is out of range");
  }
  setDecision(mesh, isRequested, rejectionReason, primitives);
  return true;
}

static bool beginCommitOf(QuadMesh* mesh) { return beginCommitOfMesh(mesh, mesh->vertices[0] && mesh->quads, "quads"); }
static bool beginCommitOf(TriangleMesh* mesh) {
  return beginCommitOfMesh(mesh, mesh->vertices[0] && mesh->triangles, "triangles");
}

/*! Uncompressed geometries are checked without tasks. */
template<typename Mesh>
static bool beginIsolatedCommit(Mesh* mesh) {
  if (!requestsCompression(mesh)) return beginCommitOf(mesh);
  bool changed = false;
  runIsolated([&] { changed = beginCommitOf(mesh); });
  return changed;
}

bool beginCommit(SubdivMesh* mesh) { return beginIsolatedCommit(mesh); }
bool beginCommit(GridMesh* mesh) { return beginIsolatedCommit(mesh); }
bool beginCommit(QuadMesh* mesh) { return beginIsolatedCommit(mesh); }
bool beginCommit(TriangleMesh* mesh) { return beginIsolatedCommit(mesh); }

void endCommit(SubdivMesh* mesh) {
  CageMemory::freeSortedEdges(mesh);
  runIsolated([&] { markUnsupportedFaces(mesh); });
  if (buildBlocksNow(mesh)) CageMemory::releaseInput(mesh);
}

/*! If blocks were built, releases the vertices, and the primitives unless rtcInterpolate needs them for vertex
 *  attributes. */
template<typename Mesh, typename Primitives>
static void endCommitOfDiced(Mesh* mesh, Primitives& primitives) {
  if (!buildBlocksNow(mesh)) return;
  for (auto& buffer : mesh->vertices) buffer = BufferView<Vec3fa>();
  mesh->vertices0 = BufferView<Vec3fa>();
  if (mesh->vertexAttribs.empty()) primitives = Primitives();
}

void endCommit(GridMesh* mesh) { endCommitOfDiced(mesh, mesh->grids); }
void endCommit(QuadMesh* mesh) { endCommitOfDiced(mesh, mesh->quads); }
void endCommit(TriangleMesh* mesh) { endCommitOfDiced(mesh, mesh->triangles); }

/*! True if a geometry has the grids, quads or triangles that rtcInterpolate reads. Also true for cages:
 *  requireSupported() checks their topology. */
static bool hasPrimitives(const CompressibleGeometry* geometry) {
  switch (geometry->ownType) {
  case Geometry::GTY_GRID_MESH: return bool(static_cast<const GridMesh*>(geometry)->grids);
  case Geometry::GTY_QUAD_MESH: return bool(static_cast<const QuadMesh*>(geometry)->quads);
  case Geometry::GTY_TRIANGLE_MESH: return bool(static_cast<const TriangleMesh*>(geometry)->triangles);
  default: return true;
  }
}

void CompressibleGeometry::requireInput(RTCBufferType type) const {
  if (surface.inputReleased && (type == RTC_BUFFER_TYPE_VERTEX || !hasPrimitives(this)))
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, inputWasReleased);
}

void* requireBuffer(Geometry* geometry, void* data) {
  const CompressibleGeometry* const own = asCompressible(geometry);
  if (!data && own && own->surface.inputReleased) throw_RTCError(RTC_ERROR_INVALID_OPERATION, inputWasReleased);
  return data;
}
} // namespace embree
