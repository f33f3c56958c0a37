// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks of scenes in the memory of a device. Those of a compressed surface are sent once, whichever scenes have it, until the
 * surface changes; the others belong to the scene that sends them. */

#include "memory.h"
#include "kernels/cbvh/flat/flat_scene.h"

namespace embree { namespace vulkan {

/* A block that a scene needs, and where the device has it. */
struct PlacedBlock
{
  const cbvh::FlatBlock* block;
  uint64_t build;                // of its surface (FlatGeometry), or 0
  VkDeviceAddress address = 0;
};

/* One build of a surface on a device. */
struct UploadedSurface
{
  struct Place { const void* data; VkDeviceAddress address; };

  std::vector<std::shared_ptr<Buffer>> buffers;   // small surfaces share them
  std::vector<Place> places;                      // of its blocks, in the order of their host's addresses

  VkDeviceAddress addressOf(const void* data) const;
};

/* What a scene's blocks are in. */
struct BlockBuffers
{
  std::vector<std::shared_ptr<Buffer>> own;
  std::vector<std::shared_ptr<const UploadedSurface>> surfaces;
  size_t importedBytes = 0;

  size_t bytes() const;   // of all, each buffer once
};

/* Both throw VulkanError if the header of a block that is new to the device does not hold: a device reads what it says, wherever
 * that is. */

/* Uses blocks where they lie in the host's memory. Sets the addresses. */
BlockBuffers importBlocks(Device& device, std::vector<PlacedBlock>& blocks);

/* Sends what the device has not yet. Sets the addresses. */
BlockBuffers copyBlocks(Device& device, Uploader& uploader, std::vector<PlacedBlock>& blocks);

}} // namespace embree::vulkan
