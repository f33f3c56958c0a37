// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The choice between tiles and cVERT for a scene's surfaces at rest, within the budget of the device (the setting
 * memory). Both have the same hits; tiles are traced faster, and take about twice the bytes. A surface whose bounds are
 * large is reached by many rays: tiles are given to the surfaces with the most area per byte that they add. What has a
 * form keeps it unless the bytes do not suffice, so that edits of one surface do not convert others. */

#include "../blocks/surface_conversion.h"
#include "../settings/memory_budget.h"
#include <algorithm>

namespace embree::isa {
class FormChoice {
public:
  typedef std::shared_ptr<const SurfaceBlocks> Blocks;

  explicit FormChoice(Scene* scene) : scene(scene), budget(*scene->device->compression.memory) {}

  /*! blocks: replaced if the surface gets the other form. Must be convertible. */
  void add(CompressibleGeometry* geometry, Blocks& blocks) {
    surfaces.push_back(
        Surface{geometry, &blocks, blocks->types >> cbvh::TILE_BLOCK & 1u ? cbvh::TILE_BLOCK : cbvh::VERT_BLOCK});
  }

  /*! Converts surfaces. treeBytes: of the scene's trees that will be built. */
  void choose(size_t treeBytes) {
    std::stable_sort(surfaces.begin(), surfaces.end(),
                     [](const Surface& a, const Surface& b) { return a.gain() > b.gain(); });
    for (size_t i = surfaces.size(); i-- && !fits(treeBytes);)
      if (surfaces[i].form == cbvh::TILE_BLOCK) convert(surfaces[i], cbvh::VERT_BLOCK);
    for (Surface& surface : surfaces)
      if (surface.form == cbvh::VERT_BLOCK && fits(treeBytes + surface.bytesOfTiles(scene->device))) {
        const Blocks before = *surface.blocks;
        convert(surface, cbvh::TILE_BLOCK);
        const size_t freed = before.use_count() == 1 ? before->bytes() : 0; // unless other scenes trace it
        if (!fits(treeBytes, freed)) set(surface, before, cbvh::VERT_BLOCK);
      }
  }

  bool hasTiles() const {
    return std::any_of(surfaces.begin(), surfaces.end(),
                       [](const Surface& surface) { return surface.form == cbvh::TILE_BLOCK; });
  }

private:
  /*! True if the budget suffices for everything that counts, and further bytes, once others are freed. */
  bool fits(size_t furtherBytes, size_t freedBytes = 0) const {
    return budget.used() + furtherBytes <= budget.limit + freedBytes;
  }

  struct Surface {
    CompressibleGeometry* geometry;
    Blocks* blocks;
    cbvh::BlockType form;

    /*! Bytes that tiles add, before they exist: an estimate. */
    size_t bytesOfTiles(Device* device) const {
      const size_t tiles = cbvh::estimateBytes(device, **blocks, cbvh::TILE_BLOCK), now = (*blocks)->bytes();
      return tiles > now ? tiles - now : 0;
    }

    float gain() const { return area((*blocks)->bounds) / float((*blocks)->numPrimRefs + 1); }
  };

  void convert(Surface& surface, cbvh::BlockType form) {
    set(surface, cbvh::convertSurface(scene->device, *surface.blocks, form, [this] { scene->progressMonitor(0.0); }),
        form);
  }

  static void set(Surface& surface, const Blocks& blocks, cbvh::BlockType form) {
    *surface.blocks = blocks;
    cbvh::replaceBlocks(surface.geometry, blocks);
    surface.form = form;
  }

  Scene* const scene;
  const cbvh::MemoryBudget& budget;
  std::vector<Surface> surfaces;
};
} // namespace embree::isa
