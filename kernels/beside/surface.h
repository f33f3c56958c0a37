// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A surface: a geometry of the kernels that releases its input in commits. */

#include "context.h"

#include "cbvh/core/compression.h"

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

namespace embree { namespace beside {

/* A geometry, with the data of its callbacks. */
struct Input
{
  RTCGeometry geometry;
  unsigned int numPrimitives = 0;
  bool isMesh = false;
  size_t numEdges = 0;                // one per index of a cage, otherwise 0
  CbvhDisplacementFunction displacement = nullptr;
  void* displacementPtr = nullptr;
  std::vector<unsigned int> widths;   // width of each attribute
  // of cages with attributes: faces without 4 corners, and their numbers of corners
  std::vector<std::pair<unsigned int, unsigned int>> nonQuads;
  CbvhProgressFunction progress = nullptr; // set during a commit
  void* progressPtr = nullptr;

  /* The geometry, for functions of the core. */
  embree::Geometry* inner() const { return (embree::Geometry*)geometry; }

  /* Throws unless the face exists, and u and v are its parameters, numbered as in hits. */
  void checkParameters(unsigned int primID, float u, float v) const;

  Input(RTCDevice device, RTCGeometryType type) : geometry(rtcNewGeometry(device, type)) {}
  explicit Input(RTCGeometry geometry) : geometry(geometry) {} // takes ownership
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

  /* Sets the committed geometry's mask to the last value of setMask(). */
  void applyMask();

  void commit(CbvhProgressFunction progress, void* userPtr);
  void save(const char* path) const;
  void load(const char* path);

  /* Input of the last commit. Throws if there is none. The result keeps the input alive if a callback commits or
   * releases the surface. */
  std::shared_ptr<const embree::beside::Input> committed() const;

  /* Input whose attributes are interpolated. During a commit or dicing, this is the pending cage. */
  std::shared_ptr<const embree::beside::Input> interpolated() const;
  const embree::beside::Input* last() const { return pending ? pending.get() : current.get(); }

  const embree::beside::Held<CbvhContextTy> context;

private:
  typedef std::shared_ptr<embree::beside::Input> InputPtr;

  /* Exists while the surface is changed. The constructor throws if another change is in progress, for example if a
   * commit's callback changes the surface. */
  class Change
  {
  public:
    explicit Change(CbvhSurfaceTy& surface);
    ~Change() { surface.isChanging = false; }

  private:
    CbvhSurfaceTy& surface;
  };

  void commitInput();

  /* Settings of the next commit. */
  static embree::CompressionSettings settingsOf(const CbvhAccuracy& accuracy, bool isLossless);

  void setVertices(RTCGeometry geometry, const CbvhVertices& vertices, bool copies);
  /* Throws, and replaces nothing, if the device reported an error. */
  void setPending(InputPtr input);

  InputPtr current, pending;    // input that is committed, and of the next commit
  CbvhAccuracy accuracy = CbvhAccuracy(), committedAccuracy = CbvhAccuracy();
  bool isLossless = false, committedLossless = false;
  unsigned int mask = ~0u, appliedMask = ~0u; // set value, and the committed geometry's
  std::atomic<bool> isChanging{false}; // set while a Change exists
  std::atomic<bool> isPendingInUse{false}; // callbacks of the pending input may be called
};
