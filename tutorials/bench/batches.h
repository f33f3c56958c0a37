// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which variants of a group are in memory, and measured in turns, at a time. */

#include "building/memory.h"
#include "building/representation.h"

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

/* A representation on an instruction set, by a library. */
struct Variant
{
  Representation representation;
  std::string isa;
  size_t library = 0; // index of it
};

/* Whether they differ at most by their libraries. */
bool sameButLibrary(const Variant& a, const Variant& b);

struct Batches
{
  std::vector<Variant> baselines;         // GRID, one an ISA and library; in memory all the time
  std::vector<std::vector<Variant>> rest; // at least one, may be empty
  std::vector<Variant> tooLarge;
  std::vector<Variant> unknown;           // to their libraries
};

/* Fills batches in the order given as long as their upper estimates fit. What differs by the
 * library only is always in one batch.
 * available: bytes. compresses: of each library, whether it has
 * compressed representations. */
Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    const BuildSize& size, size_t available, const std::vector<bool>& compresses = {true});

/* Upper estimates of what the baselines take, and of what they and one that is too large take,
 * by all libraries. */
size_t baselineBytes(const Batches& batches, const BuildSize& size);
size_t neededBytes(const Batches& batches, const Variant& tooLarge, const BuildSize& size);

/* Says that `what`, a representation, needs more than is available. */
std::string sizeMessage(const std::string& what, size_t quads, size_t needed, size_t available);

} // namespace cbvh
