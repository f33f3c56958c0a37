// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides the variants of a group into batches that are in memory, and measured alternately, at the same time. */

#include "building/memory.h"
#include "building/representation.h"

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

/* A representation on an instruction set, built by a library. */
struct Variant
{
  Representation representation;
  std::string isa;
  size_t library = 0; // index of the library
};

/* True if the variants differ at most by their libraries. */
bool differOnlyByLibrary(const Variant& a, const Variant& b);

struct Batches
{
  std::vector<Variant> baselines;         // GRID, one per ISA and library; always in memory
  std::vector<std::vector<Variant>> rest; // at least one batch, which may be empty
  std::vector<Variant> tooLarge;
  std::vector<Variant> unknown;           // representations that their libraries do not have
};

/* Fills batches in order as long as upper estimates of their memory fit into `available` bytes. Variants that differ
 * only by the library are always in the same batch. `compresses` is true for libraries with compressed
 * representations. */
Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    const BuildSize& size, size_t available, const std::vector<bool>& compresses = {true});

/* Return upper estimates of the memory, in bytes, of the baselines, and of the baselines together with a variant that
 * is too large, built by all libraries. */
size_t baselineBytes(const Batches& batches, const BuildSize& size);
size_t neededBytes(const Batches& batches, const Variant& tooLarge, const BuildSize& size);

/* Returns the message that a representation needs more memory than is available. */
std::string sizeMessage(const std::string& what, size_t quads, size_t needed, size_t available);

} // namespace cbvh
