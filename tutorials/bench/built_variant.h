// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "library.h"
#include "results.h"
#include "building/built_scene.h"

#include <memory>
#include <optional>
#include <vector>

namespace programs {

class BuiltVariant {
public:
  /* Builds the variant and appends its result to the group, where its address must stay valid. The variant's ISA
   * overrides the settings. The library must outlive the variant. Throws Error. */
  BuiltVariant(const Model& model, const Variant& variant, BuildSettings settings, const Library& library,
               Group& group);

  /* Also makes the variant's library current. */
  const BuiltScene& use() const {
    scene.get_deleter().library->use();
    return *scene;
  }

  VariantResult& result() const { return *variantResult; }
  const Variant& variant() const { return variantResult->variant; }

private:
  struct Deleter {
    const Library* library;
    void operator()(BuiltScene* scene) const;
  };
  std::unique_ptr<BuiltScene, Deleter> scene;
  VariantResult* variantResult;
};

/* Index of the first library's counterpart of variant i. Empty if there is none, or if it is i itself. */
std::optional<size_t> findInFirstLibrary(const std::vector<BuiltVariant>& batch, size_t i);

} // namespace programs
