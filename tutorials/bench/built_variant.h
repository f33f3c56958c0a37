// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A variant in memory, and what its memory is made of. */

#include "library.h"
#include "results.h"
#include "building/built_scene.h"

#include <memory>
#include <optional>
#include <vector>

namespace cbvh {

class BuiltVariant
{
public:
  /* Builds, and starts the variant's result at the end of a group's, where it stays. settings:
   * their ISA is the variant's. library: the variant's, outlives it. Throws Error, Cancelled. */
  BuiltVariant(const Model& model, const Variant& variant, BuildSettings settings, const Library& library, Group& group);

  /* The scene, whose library is in use from now on. */
  const BuiltScene& use() const
  {
    scene.get_deleter().library->use();
    return *scene;
  }

  VariantResult& result() const { return *found; }
  const Variant& variant() const { return found->variant; }

private:
  struct Removal
  {
    const Library* library;
    void operator()(BuiltScene* scene) const;
  };
  std::unique_ptr<BuiltScene, Removal> scene;
  VariantResult* found;
};

/* Which variant of a batch is the i-th of the first library; none if that does not have it, or
 * if it is the i-th itself. */
std::optional<size_t> sameOfFirstLibrary(const std::vector<BuiltVariant>& batch, size_t i);

} // namespace cbvh
