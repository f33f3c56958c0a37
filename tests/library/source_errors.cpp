// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sources that lack one member each, for source_errors.sh. The compiler must reject each of them with the message after
 * "expected:", and no other class. The first class is complete. */

#include "sphere_source.h"

namespace embree::isa {
static_assert(isSource<SphereSource>(), "the sphere is a source");

/*! the sphere with other patches */
template<typename Other> struct With : public SphereSource {
  typedef Other Patch;
  struct Writer {
    Writer(const With&, BlockStore&, cbvh::BuildStatistics&);
    bool write(size_t, Patch&);
  };
};

// expected: size_t size() const
struct NoSize : public SphereSource {
  size_t size() const = delete;
};
static_assert(isSource<NoSize>(), "");

// expected: size_t estimateBlocks() const
struct NoEstimate : public SphereSource {
  size_t estimateBlocks();
};
static_assert(isSource<NoEstimate>(), "");

// expected: size_t perTask(bool isSmall) const
struct NoPerTask : public SphereSource {
  size_t perTask() const;
};
static_assert(isSource<NoPerTask>(), "");

// expected: void prepare(size_t perTask, const Progress& progress)
struct NoPrepare : public SphereSource {
  void prepare(size_t);
};
static_assert(isSource<NoPrepare>(), "");

// expected: void release()
struct NoRelease : public SphereSource {
  void release() = delete;
};
static_assert(isSource<NoRelease>(), "");

// expected: void forEachPatch(size_t primitive, Scratch& scratch, const Closure& closure) const
struct NoPatches : public SphereSource {
  void forEachPatch(size_t) const;
};
static_assert(isSource<NoPatches>(), "");

// expected: bool isInvalid(size_t primitive, bool hasInvalidQuads) const
struct NoInvalid : public SphereSource {
  bool isInvalid(size_t) const;
};
static_assert(isSource<NoInvalid>(), "");

// expected: size_t quadsWithoutSurface(size_t primitive) const
struct NoQuads : public SphereSource {
  size_t quadsWithoutSurface() const;
};
static_assert(isSource<NoQuads>(), "");

// expected: cbvh::InvalidVertex invalidVertex(size_t primitive) const
struct NoInvalidVertex : public SphereSource {
  cbvh::InvalidVertex invalidVertex() const;
};
static_assert(isSource<NoInvalidVertex>(), "");

// expected: bool isUnsupported(size_t primitive) const
struct NoUnsupported : public SphereSource {
  bool isUnsupported() const;
};
static_assert(isSource<NoUnsupported>(), "");

// expected: size_t bytesInEmbree(const SurfacePatch& patch) const
struct NoBytes : public SphereSource {
  size_t bytesInEmbree() const;
};
static_assert(isSource<NoBytes>(), "");

// expected: static const bool isDeterministic
struct NoConstant : public SphereSource {
  static bool isDeterministic;
};
static_assert(isSource<NoConstant>(), "");

// expected: a type Scratch with Scratch(Device*)
struct OtherScratch : public PatchVertices {
  OtherScratch();
};
struct NoScratch : public SphereSource {
  typedef OtherScratch Scratch;
};
static_assert(isSource<NoScratch>(), "");

// expected: a type Writer with Writer(const Source&, BlockStore&, cbvh::BuildStatistics&)
struct NoWriter : public SphereSource {
  struct Writer {
    Writer();
    bool write(size_t, Patch&);
  };
};
static_assert(isSource<NoWriter>(), "");

// expected: bool Writer::write(size_t primitive, Patch& patch)
struct NoWrite : public SphereSource {
  struct Writer {
    Writer(const NoWrite&, BlockStore&, cbvh::BuildStatistics&);
  };
};
static_assert(isSource<NoWrite>(), "");

// expected: a type Patch derived from SurfacePatch
struct Foreign {
  Foreign(const Foreign& other, SphereSource::Scratch& scratch);
  PatchVertices& evaluate(unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned step);
  SphereSource::Patch::Side side(int s, unsigned step) const;
  int latticeExponent(unsigned step) const;
};
static_assert(isSource<With<Foreign>>(), "");

// expected: Patch(const Patch& other, Scratch& scratch)
struct NoCopy : public SphereSource::Patch {
  NoCopy();
};
static_assert(isSource<With<NoCopy>>(), "");

// expected: PatchVertices& Patch::evaluate(unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned step)
struct NoEvaluate : public SphereSource::Patch {
  NoEvaluate(const NoEvaluate&, SphereSource::Scratch&);
  void evaluate();
};
static_assert(isSource<With<NoEvaluate>>(), "");

// expected: Patch::side(int s, unsigned step) const, whose result has a rate
struct NoRate : public SphereSource::Patch {
  struct Side {
    SharedVertex operator[](unsigned k) const;
  };
  NoRate(const NoRate&, SphereSource::Scratch&);
  Side side(int, unsigned) const;
};
static_assert(isSource<With<NoRate>>(), "");

// expected: Patch::side(int s, unsigned step) const, whose result has SharedVertex operator[](unsigned k) const
struct NoVertex : public SphereSource::Patch {
  struct Side {
    unsigned rate;
  };
  NoVertex(const NoVertex&, SphereSource::Scratch&);
  Side side(int, unsigned) const;
};
static_assert(isSource<With<NoVertex>>(), "");

// expected: int Patch::latticeExponent(unsigned step) const
struct NoLattice : public SphereSource::Patch {
  NoLattice(const NoLattice&, SphereSource::Scratch&);
  void latticeExponent(unsigned) const;
};
static_assert(isSource<With<NoLattice>>(), "");
} // namespace embree::isa
