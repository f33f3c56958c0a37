// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays of the application's Embree, version 3.13 or 4, whose RTCHitN differ in the number of instance levels and of
 * members for each level. RTCRayN and RTCHitN are arrays of words: word w of ray i is at w * N + i. */

#include "group.h"
#include "structs.h"

#include <cstring>

namespace {

typedef unsigned int __attribute__((may_alias)) Word;

enum Words : unsigned int {
  RAY_DIR = 4,
  RAY_TFAR = 8,
  RAY_WORDS = 12,
  HIT_PRIM_ID = 5,
  HIT_GEOM_ID = 6,
  HIT_INST_ID = 7 // instIDs of all levels, then the primIDs of instances of all levels, if the Embree has these
};

constexpr unsigned int maxLevels = 32;

Word& wordOf(void* of, unsigned int N, unsigned int word, unsigned int i) { return ((Word*)of)[word * N + i]; }

void copyWords(void* to, unsigned int toN, unsigned int toI, void* from, unsigned int fromN, unsigned int fromI,
               unsigned int count) {
  for (unsigned int word = 0; word < count; word++) wordOf(to, toN, word, toI) = wordOf(from, fromN, word, fromI);
}

/* Writes the IDs of the application's scene into hit i of N. */
void writeHitIDs(const CbvhGeometryQuery& query, void* hits, unsigned int N, unsigned int i) {
  const unsigned int surface = wordOf(hits, N, HIT_GEOM_ID, i);
  if (surface != 0) wordOf(hits, N, HIT_PRIM_ID, i) += cbvhGetGroupFirstPrimitive(query.group, surface);
  wordOf(hits, N, HIT_GEOM_ID, i) = query.geomID;
  for (unsigned int level = 0; level < query.numLevels; level++) {
    wordOf(hits, N, HIT_INST_ID + level, i) = query.instIDs[level];
    if (query.instPrimIDs) wordOf(hits, N, HIT_INST_ID + query.numLevels + level, i) = query.instPrimIDs[level];
  }
}

/* Calls the application's filter for one hit at a time: IDs must be translated, and the application's RTCHit may be
 * larger. Takes over what a filter may change. */
void filterHits(const CbvhFilterArguments* args) {
  const CbvhGeometryQuery& query = *(const CbvhGeometryQuery*)args->userPtr;
  for (unsigned int i = 0; i < args->count; i++) {
    if (args->valid[i] == 0) continue;
    alignas(16) Word ray[RAY_WORDS], hit[HIT_INST_ID + 2 * maxLevels];
    copyWords(ray, 1, 0, args->rays, args->count, i, RAY_WORDS);
    copyWords(hit, 1, 0, args->hits, args->count, i, HIT_INST_ID);
    const unsigned int primID = hit[HIT_PRIM_ID];
    writeHitIDs(query, hit, 1, 0);
    const unsigned int firstPrimitive = hit[HIT_PRIM_ID] - primID;
    int valid = -1;
    query.filter(query.filterUserPtr, &valid, ray, hit);
    if (!valid) {
      args->valid[i] = 0;
      continue;
    }
    wordOf(args->rays, args->count, RAY_TFAR, i) = ray[RAY_TFAR];
    hit[HIT_PRIM_ID] -= firstPrimitive; // the caller adds it again
    copyWords(args->hits, args->count, i, hit, 1, 0, HIT_PRIM_ID + 1);
  }
}

/* Returns CBVH_QUERY_FLAG_COHERENT if more than half of the rays of a packet are active and all of these have the same
 * signs of directions. */
unsigned int packetFlags(void* rays, unsigned int N, const int* valid) {
  unsigned int count = 0, negative[3] = {0, 0, 0};
  for (unsigned int i = 0; i < N; i++) {
    if (valid[i] == 0) continue;
    count++;
    for (unsigned int axis = 0; axis < 3; axis++) negative[axis] += wordOf(rays, N, RAY_DIR + axis, i) >> 31;
  }
  if (2 * count <= N) return 0;
  for (unsigned int n : negative)
    if (n != 0 && n != count) return 0;
  return CBVH_QUERY_FLAG_COHERENT;
}

/* Not inlined, to keep the usual path short. */
__attribute__((noinline)) void rejectQuery(const CbvhGeometryQuery* query) {
  embree::capi::rejectArgument(query ? "numLevels is above 32" : "query is NULL");
}

inline bool isValid(const CbvhGeometryQuery* query) {
  if (__builtin_expect(query && query->numLevels <= maxLevels, true)) return true;
  rejectQuery(query);
  return false;
}

/* Options of the inner query. get() returns NULL for the defaults, which is quicker for single rays. */
class InnerQuery {
public:
  InnerQuery(const CbvhGeometryQuery& query, unsigned int moreFlags) : flags(query.flags | moreFlags) {
    if (flags == 0 && !query.filter) return;
    options = {sizeof(options), flags, query.filter ? filterHits : nullptr, (void*)&query};
    used = &options;
  }
  const CbvhQuery* get() const { return used; }

private:
  const unsigned int flags;
  union {
    CbvhQuery options; // not initialized unless it is used
  };
  const CbvhQuery* used = nullptr;
};

} // namespace

void cbvhIntersectGeometry(const CbvhGeometryQuery* query) {
  if (!isValid(query)) return;
  const unsigned int N = query->N;
  void* const rays = query->rays;
  void* const hits = (Word*)rays + RAY_WORDS * N;
  if (N == 1) {
    if (query->valid[0] && cbvhIntersect1(query->group, (CbvhRayHit*)rays, InnerQuery(*query, 0).get()))
      writeHitIDs(*query, hits, 1, 0);
    return;
  }
  if (N == 4 || N == 8 || N == 16) {
    const InnerQuery inner(*query, packetFlags(rays, N, query->valid));
    const auto intersect = N == 4 ? cbvhIntersect4 : N == 8 ? cbvhIntersect8 : cbvhIntersect16;
    const unsigned int found = intersect(query->group, query->valid, rays, inner.get());
    for (unsigned int i = 0; i < N; i++)
      if (found & (1u << i)) writeHitIDs(*query, hits, N, i);
    return;
  }
  const InnerQuery inner(*query, 0);
  for (unsigned int i = 0; i < N; i++) {
    if (query->valid[i] == 0) continue;
    CbvhRayHit one;
    copyWords(&one.ray, 1, 0, rays, N, i, RAY_WORDS);
    one.hit.geomID = one.hit.instID = RTC_INVALID_GEOMETRY_ID;
    if (!cbvhIntersect1(query->group, &one, inner.get())) continue;
    wordOf(rays, N, RAY_TFAR, i) = wordOf(&one.ray, 1, RAY_TFAR, 0);
    copyWords(hits, N, i, &one.hit, 1, 0, HIT_INST_ID);
    writeHitIDs(*query, hits, N, i);
  }
}

void cbvhOccludedGeometry(const CbvhGeometryQuery* query) {
  if (!isValid(query)) return;
  const unsigned int N = query->N;
  void* const rays = query->rays;
  if (N == 1) {
    if (query->valid[0]) cbvhOccluded1(query->group, (CbvhRay*)rays, InnerQuery(*query, 0).get());
    return;
  }
  if (N == 4 || N == 8 || N == 16) {
    const InnerQuery inner(*query, packetFlags(rays, N, query->valid));
    const auto occluded = N == 4 ? cbvhOccluded4 : N == 8 ? cbvhOccluded8 : cbvhOccluded16;
    occluded(query->group, query->valid, rays, inner.get());
    return;
  }
  const InnerQuery inner(*query, 0);
  for (unsigned int i = 0; i < N; i++) {
    if (query->valid[i] == 0) continue;
    CbvhRay one;
    copyWords(&one, 1, 0, rays, N, i, RAY_WORDS);
    if (cbvhOccluded1(query->group, &one, inner.get())) wordOf(rays, N, RAY_TFAR, i) = wordOf(&one, 1, RAY_TFAR, 0);
  }
}
