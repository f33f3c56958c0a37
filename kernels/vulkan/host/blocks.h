// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks in device memory. Scenes on a device share the uploaded blocks of a compressed surface until it is rebuilt.
 * Other blocks belong to one scene. */

#include "memory.h"
#include "kernels/cbvh/backend/flat_scene.h"

namespace embree::vulkan {

struct PlacedBlock {
  const cbvh::FlatBlock* block;
  uint64_t buildID; // FlatGeometry::buildID; 0 if scenes do not share the surface
  VkDeviceAddress address = 0;
};

/* The blocks of one build of a surface (FlatGeometry::buildID) on a device. */
struct UploadedSurface {
  struct Place {
    const void* source; // FlatBlock::source
    VkDeviceAddress address;
  };

  std::vector<std::shared_ptr<Buffer>> buffers; // shared between small surfaces
  std::vector<Place> places;                    // sorted by source

  /* Device address of a block, or 0 if the surface does not contain it. */
  VkDeviceAddress addressOf(const void* source) const;
};

/* Keeps the device memory of a scene's blocks alive. */
struct BlockBuffers {
  std::vector<std::shared_ptr<Buffer>> own;
  std::vector<std::shared_ptr<const UploadedSurface>> surfaces;
  std::vector<std::shared_ptr<const cbvh::FlatScene>> imported; // those that own imported blocks
  size_t importedBytes = 0;

  size_t bytes() const; // counts shared buffers once
};

/* Both functions set the addresses of `blocks`. They throw VulkanError if a block is damaged, because shaders do not
 * check offsets. */

/* Imports the host memory that contains the blocks, without a copy. The scene must keep this memory alive.
 * Throws VulkanError, too, if the driver rejects it. */
BlockBuffers importBlocks(Device& device, std::vector<PlacedBlock>& blocks);

/* Checks and uploads the blocks that are not on the device yet. */
BlockBuffers copyBlocks(Device& device, Uploader& uploader, std::vector<PlacedBlock>& blocks);

} // namespace embree::vulkan
