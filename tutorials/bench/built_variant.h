// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A variant in memory, and what its memory is made of. */

#include "results.h"
#include "building/built_scene.h"

#include <memory>

namespace cbvh {

/* The result stays where it is for as long as the variant is measured. */
struct BuiltVariant
{
  std::unique_ptr<BuiltScene> scene;
  VariantResult* result = nullptr;
};

/* Builds, and starts the variant's result at the end of a group's. settings: their ISA is
 * the variant's. Throws Error, Cancelled. */
BuiltVariant buildVariant(const Model& model, const Variant& variant, BuildSettings settings, Group& group);

} // namespace cbvh
