// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A surface: a geometry of the kernels, which lets its input go when it is committed. */

#include "context.h"

#include "cbvh/core/compression.h"

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

namespace embree { namespace beside {

/* A geometry, and what its callbacks need. */
struct Input
{
  RTCGeometry geometry;
  unsigned int numPrimitives = 0;
  bool isMesh = false;
  size_t numEdges = 0;                // one an index; none but of cages
  CbvhDisplacementFunction displacement = nullptr;
  void* displacementPtr = nullptr;
  std::vector<unsigned int> widths;   // of attributes
  std::vector<std::pair<unsigned int, unsigned int>> otherFaces; // of cages with attributes: faces that have not 4 corners, and how many they have
  CbvhProgressFunction progress = nullptr; // during a commit
  void* progressPtr = nullptr;

  /* The geometry, for functions of the core. */
  embree::Geometry* inner() const { return (embree::Geometry*)geometry; }

  /* Throws unless the face exists and u, v are parameters of it, as hits have them. */
  void checkParameters(unsigned int primID, float u, float v) const;

  Input(RTCDevice device, RTCGeometryType type) : geometry(rtcNewGeometry(device, type)) {}
  explicit Input(RTCGeometry geometry) : geometry(geometry) {} // which it releases
  ~Input() { rtcReleaseGeometry(geometry); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
};

}} // namespace embree::beside

struct CbvhSurfaceTy : embree::beside::Counted
{
  explicit CbvhSurfaceTy(CbvhContext context) : context(context) {}

  void set(const CbvhCage& cage);
  void set(const CbvhGrids& grids);
  void set(const CbvhMesh& mesh);
  void dice(const CbvhDicing& dicing, float* rates);
  void set(const CbvhAccuracy& accuracy);
  void setLossless(bool lossless);
  void setMask(unsigned int mask);

  /* Gives the committed geometry the mask that was set last. */
  void applyMask();

  void commit(CbvhProgressFunction progress, void* userPtr);
  void save(const char* path) const;
  void load(const char* path);

  /* Throws if it was not committed. The caller keeps the input alive: a callback may commit or release the surface. */
  std::shared_ptr<const embree::beside::Input> committed() const;

  /* What attributes are interpolated of: during a commit or dicing the cage that is worked on. */
  std::shared_ptr<const embree::beside::Input> interpolated() const;
  const embree::beside::Input* last() const { return pending ? pending.get() : current.get(); }

  const embree::beside::Held<CbvhContextTy> context;

private:
  typedef std::shared_ptr<embree::beside::Input> Owned;

  /* A change of the surface. Throws if there is one already, as in the callbacks of a commit. */
  class Change
  {
  public:
    explicit Change(CbvhSurfaceTy& surface);
    ~Change() { surface.isChanging = false; }

  private:
    CbvhSurfaceTy& surface;
  };

  void commitInput();

  /* How the next commit stores the surface. */
  static embree::CompressionSettings settingsOf(const CbvhAccuracy& accuracy, bool isLossless);

  void setVertices(RTCGeometry geometry, const CbvhVertices& vertices, bool copies);
  void keep(Owned input);

  Owned current, pending;    // as it was committed, and what the next commit takes
  CbvhAccuracy accuracy = CbvhAccuracy(), committedAccuracy = CbvhAccuracy();
  bool isLossless = false, committedLossless = false;
  unsigned int mask = ~0u, appliedMask = ~0u; // as set, and of the committed geometry
  std::atomic<bool> isChanging{false}, isWorking{false}; // isWorking: callbacks of the pending input may be called
};
