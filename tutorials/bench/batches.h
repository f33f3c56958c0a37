// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which variants of a group are in memory, and measured in turns, at a time. */

#include "building/representation.h"

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

/* A representation on an instruction set. */
struct Variant
{
  Representation representation;
  std::string isa;
};

struct Batches
{
  std::vector<Variant> baselines;         // GRID, one an ISA; in memory all the time
  std::vector<std::vector<Variant>> rest; // at least one, may be empty
  std::vector<Variant> tooLarge;
};

/* Fills batches in the order given as long as their upper estimates fit.
 * quads: of the tessellation. available: bytes. */
Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    size_t quads, size_t available);

/* Upper estimates of what the baselines take, and of what they and one variant take. */
size_t baselineBytes(const Batches& batches, size_t quads);
size_t neededBytes(const Batches& batches, const Variant& variant, size_t quads);

/* Says that `what`, a representation, needs more than is available. */
std::string sizeMessage(const std::string& what, size_t quads, size_t needed, size_t available);

} // namespace cbvh
