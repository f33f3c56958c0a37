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
  void add(CompressibleGeometry* geometry, Blocks& blocks) { surfaces.push_back(Surface{geometry, &blocks}); }

  /*! Converts surfaces. treeBytes: of the scene's trees that will be built. */
  void choose(size_t treeBytes) {
    std::stable_sort(surfaces.begin(), surfaces.end(),
                     [](const Surface& a, const Surface& b) { return a.gain() > b.gain(); });
    removeTiles(treeBytes);
    convert(tilesThatFit(treeBytes));
    removeTiles(treeBytes); // estimates may be exceeded
  }

  bool hasTiles() const {
    return std::any_of(surfaces.begin(), surfaces.end(), [](const Surface& surface) { return surface.hasTiles(); });
  }

private:
  struct Surface {
    CompressibleGeometry* geometry;
    Blocks* blocks;

    bool hasTiles() const { return cbvh::formOf(**blocks) == cbvh::TILE_BLOCK; }
    float gain() const { return area((*blocks)->bounds) / float((*blocks)->numPrimRefs + 1); }
  };

  /*! Bytes by which everything that counts would exceed the budget, with further bytes. */
  size_t excess(size_t furtherBytes) const {
    const size_t bytes = budget.used() + furtherBytes;
    return bytes > budget.limit ? bytes - budget.limit : 0;
  }

  /*! Returns how much smaller the form with fewer bytes is. */
  size_t difference(const Surface& surface) const {
    const size_t now = (*surface.blocks)->bytes(), other = cbvh::bytesInOtherForm(scene->device, **surface.blocks);
    return max(now, other) - min(now, other);
  }

  /*! Converts tiles with the least gain until everything fits, or there are none left. */
  void removeTiles(size_t treeBytes) {
    while (const size_t toFree = excess(treeBytes)) {
      std::vector<Surface*> removed;
      size_t freed = 0;
      for (size_t i = surfaces.size(); i-- && freed < toFree;)
        if (surfaces[i].hasTiles()) {
          removed.push_back(&surfaces[i]);
          freed += difference(surfaces[i]);
        }
      if (removed.empty()) return;
      convert(removed);
    }
  }

  std::vector<Surface*> tilesThatFit(size_t treeBytes) {
    std::vector<Surface*> chosen;
    if (excess(treeBytes + 1)) return chosen;
    parallel_for(size_t(0), surfaces.size(), [&](const range<size_t>& r) { // estimates that difference() needs
      for (size_t i = r.begin(); i != r.end(); i++)
        if (!surfaces[i].hasTiles()) cbvh::bytesInOtherForm(scene->device, **surfaces[i].blocks);
    });
    size_t added = 0;
    for (Surface& surface : surfaces) {
      if (surface.hasTiles()) continue;
      const size_t bytes = difference(surface);
      if (bytes == 0 || excess(treeBytes + added + bytes)) continue;
      added += bytes;
      chosen.push_back(&surface);
    }
    return chosen;
  }

  /*! Gives surfaces their other form, in parallel. */
  void convert(const std::vector<Surface*>& chosen) {
    parallel_for(size_t(0), chosen.size(), size_t(1), [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++) {
        Blocks& blocks = *chosen[i]->blocks;
        blocks = cbvh::convertSurface(scene->device, blocks, cbvh::otherForm(cbvh::formOf(*blocks)),
                                      [this] { scene->progressMonitor(0.0); });
        cbvh::replaceBlocks(chosen[i]->geometry, blocks);
      }
    });
  }

  Scene* const scene;
  const cbvh::MemoryBudget& budget;
  std::vector<Surface> surfaces;
};
} // namespace embree::isa
