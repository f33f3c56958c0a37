// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A surface: a geometry of the kernels, which lets its input go when it is committed. */

#include "context.h"

#include <memory>
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
  void setMask(unsigned int mask);
  void commit(CbvhProgressFunction progress, void* userPtr);
  void save(const char* path) const;
  void load(const char* path);

  /* Throws where it was not committed. */
  const embree::beside::Input& committed() const;
  const embree::beside::Input* last() const { return pending ? pending.get() : current.get(); }

  const embree::beside::Held<CbvhContextTy> context;

private:
  typedef std::unique_ptr<embree::beside::Input> Owned;

  void setVertices(RTCGeometry geometry, const CbvhVertices& vertices, bool copies);
  void keep(Owned input);

  Owned current, pending;    // as it was committed, and what the next commit takes
  CbvhAccuracy accuracy = CbvhAccuracy();
  bool hasNewAccuracy = false;
  unsigned int mask = ~0u;
};
