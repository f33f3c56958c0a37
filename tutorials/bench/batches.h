// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides a group's variants into batches that fit into memory; a batch is measured alternately. */

#include "building/memory.h"
#include "building/representation.h"

#include <cstddef>
#include <string>
#include <vector>

namespace programs {

struct Variant {
  Representation representation;
  std::string isa;
  size_t library = 0;
};

/* True if at most the libraries differ. */
bool differOnlyByLibrary(const Variant& a, const Variant& b);

struct Batches {
  std::vector<Variant> baselines;            // GRID, one per ISA and library; always in memory
  std::vector<std::vector<Variant>> batches; // may be one empty batch
  std::vector<Variant> tooLarge;
  std::vector<Variant> unsupported; // not supported by their libraries
};

/* Fills batches in order while upper estimates of their memory fit into `available` bytes. Variants that differ only
 * by the library share a batch. `compresses` is true for libraries with compressed representations. */
Batches planBatches(const std::vector<Representation>& representations, const std::vector<std::string>& isas,
                    const BuildSize& size, size_t available, const std::vector<bool>& compresses = {true});

/* Upper estimates in bytes for all libraries: baselines alone, and with a variant that is too large. */
size_t baselineBytes(const Batches& batches, const BuildSize& size);
size_t neededBytes(const Batches& batches, const Variant& tooLarge, const BuildSize& size);

std::string sizeMessage(const std::string& what, size_t quads, size_t needed, size_t available);

} // namespace programs
