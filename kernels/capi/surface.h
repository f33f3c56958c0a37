// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A surface: a geometry of the kernels that builds compressed blocks when it is committed, and then releases the cage,
 * grids or mesh, except for attributes. Each cage, grids or mesh that is set is an Input, which is pending until
 * commit() makes it the current one. */

#include "context.h"

#include "cbvh/operations/compression.h"
#include "cbvh/operations/files.h"

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

namespace embree::capi {

/* A geometry of the kernels, and the user data of its callbacks. After commit(), the geometry has blocks, but no
 * vertices. */
struct Input {
  RTCGeometry geometry;
  unsigned int numPrimitives = 0;
  size_t numIndices = 0; // of a cage, otherwise 0
  CbvhDisplacementFunction displacement = nullptr;
  void* displacementUserPtr = nullptr;
  std::vector<unsigned int> widths; // floats per value of each attribute
  // if a cage has attributes: its faces without four corners, and their numbers of corners; sorted by face
  std::vector<std::pair<unsigned int, unsigned int>> nonQuads;
  CbvhProgressFunction progress = nullptr; // NULL except during a commit
  void* progressPtr = nullptr;

  embree::Geometry* embreeGeometry() const { return (embree::Geometry*)geometry; }

  /* Throws unless the face exists and contains the point (u, v), in the parametrization of hits. Requires a cage with
   * attributes. */
  void checkParameters(unsigned int primID, float u, float v) const;
  void checkAttribute(unsigned int attribute) const;

  Input(RTCDevice device, RTCGeometryType type) : geometry(rtcNewGeometry(device, type)) {}
  explicit Input(RTCGeometry geometry) : geometry(geometry) {} // takes ownership
  ~Input() { rtcReleaseGeometry(geometry); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
};

} // namespace embree::capi

struct CbvhSurfaceTy : embree::capi::RefCounted {
  explicit CbvhSurfaceTy(CbvhContext context) : context(context) {}

  /* A surface that refers to a geometry of the application, which it retains. */
  CbvhSurfaceTy(CbvhContext context, RTCGeometry geometry);

  bool refersToGeometry() const { return isReference; }

  /* Set the pending input. Cages are copied; the vertices of grids and meshes must exist until commit() succeeds or
   * other input is set. */
  void set(const CbvhCage& cage);
  void set(const CbvhGrids& grids);
  void set(const CbvhMesh& mesh);

  /* Sets the edge rates of the pending cage, or of the application's geometry, for a camera. rates: receives them, one
   * per index; may be NULL. */
  void dice(const CbvhDicingArguments& dicing, float* rates);
  void set(const CbvhAccuracy& accuracy);
  void setLossless(bool lossless);
  void setMask(unsigned int mask);

  /* Sets the committed geometry's mask to the last value of setMask(). Requires a commit or load() before. */
  void applyMask();

  /* Compresses the pending input. Without pending input, does nothing, or throws if the surface is empty or its
   * accuracy changed. If no blocks are stored, throws; the last commit then remains current, and the input pending.
   * If blocks are stored, but Embree reports an error, makes the input current and then throws.
   * CbvhGroupTy::commit() reports faces and grids that were left out. */
  void commit(CbvhProgressFunction progress, void* userPtr);

  /* Makes a geometry of a file the current input of a new surface. */
  void load(const embree::core::CompressedFile& file, size_t index);

  /* Input of the last commit, or the loaded geometry. Throws if there is neither. The result stays valid even if a
   * callback commits or releases the surface. */
  std::shared_ptr<const embree::capi::Input> committedInput() const;

  /* Input whose attributes are interpolated: during a commit or dicing the pending input, otherwise as
   * committedInput(). */
  std::shared_ptr<const embree::capi::Input> interpolationInput() const;

  /* Primitives of the input that was set last, committed or not; 0 if there is none. */
  unsigned int numPrimitives() const;

  const embree::capi::RefPtr<CbvhContextTy> context;

private:
  typedef std::shared_ptr<embree::capi::Input> InputPtr;

  /* Exists while the surface is changed. The constructor throws if another change is in progress, such as a commit
   * whose callback changes the surface, and if the surface refers to a geometry. */
  class ChangeScope {
  public:
    explicit ChangeScope(CbvhSurfaceTy& surface);
    ~ChangeScope() { surface.isChanging = false; }

  private:
    CbvhSurfaceTy& surface;
  };

  void commitInput();

  embree::CompressionSettings settingsOf(const CbvhAccuracy& accuracy, bool isLossless) const;

  /* copies: true to copy the vertices. Otherwise they must exist as long as the geometry may be committed. */
  void setVertices(RTCGeometry geometry, const CbvhVertices& vertices, bool copies);

  /* Replaces the pending input, unless the device reported an error, which it throws. */
  void setPending(InputPtr input);

  bool isReference = false;               // the application owns and commits the current input's geometry
  InputPtr current, pending;              // input of the last commit or load(), and of the next commit
  CbvhAccuracy accuracy = CbvhAccuracy(); // of the next commit
  bool isLossless = false;                // the same
  embree::CompressionSettings committedSettings = settingsOf(accuracy, isLossless);
  unsigned int mask = ~0u, appliedMask = ~0u; // value of setMask(), and value of the committed geometry
  std::atomic<bool> isChanging{false};        // set while a ChangeScope exists
  std::atomic<bool> isPendingInUse{false};    // set while callbacks of the pending input may be called
};
