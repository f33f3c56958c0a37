// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "blocks.h"
#include "kernels/cbvh/base/leaf_type.h"
#include "kernels/cbvh/files/validate_framed.h"
#include "kernels/cvert/decoder/validate_mesh.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <set>
#include <unordered_set>

namespace embree::vulkan {

using namespace cbvh;

namespace {

constexpr size_t readPadding = 16;         // bytes after a block that shaders may read
constexpr size_t ownBufferBytes = 1 << 20; // surfaces of at least this size have buffers of their own

/* block: no grid of Embree. */
BlockType typeOf(const FlatBlock& block) {
  static_assert(numReferenceTypes == meshBlockReferenceType + 1, "each type of reference to a block is known here");
  return block.type == meshBlockReferenceType                                                   ? MESH_BLOCK
         : block.type == blockReferenceType(kindTile)                                           ? TILE_BLOCK
         : block.type == movingBlockReferenceType || block.type == blockReferenceType(kindVert) ? VERT_BLOCK
                                                                                                : FRAMED_BLOCK;
}

/* True if shaders may read up to readPadding bytes after the block. */
bool isReadPastEnd(const FlatBlock& block) {
  return block.type != gridLeafReferenceType && typeOf(block) != FRAMED_BLOCK;
}

/* Throws VulkanError if a block is damaged. Grids of Embree need no check. */
void requireValid(const FlatBlock& block) {
  if (block.type == gridLeafReferenceType) return;
  cvert::Reason reason;
  switch (typeOf(block)) {
  case FRAMED_BLOCK:
    reason = validateFramedBlock(block.data, block.bytes);
    if (!reason && blockReferenceType(kindOf(((const BlockHeader*)block.data)->info)) != block.type)
      reason = {cvert::ErrorCode::DAMAGED, "its kind differs from the kind in its reference"};
    break;
  case VERT_BLOCK:
    reason = cvert::validateVert(block.data, block.bytes);
    if (!reason && block.type == movingBlockReferenceType && !isMoving(((const VertHeader*)block.data)->info))
      reason = {cvert::ErrorCode::DAMAGED, "it has one time step, and its geometry has several"};
    break;
  case MESH_BLOCK: reason = cvert::validateMesh(block.data, block.bytes); break;
  case TILE_BLOCK: break; // made in memory, from valid blocks
  }
  if (reason) throw VulkanError(RTC_ERROR_INVALID_OPERATION, "a block of the scene is not valid: " + reason.message());
}

/* The bytes of a block to upload. Omits the trees that Embree stores in grids: the scene's tree contains their
 * nodes. */
struct BlockUpload {
  uint32_t header[gridDataWord];
  size_t headerBytes = 0;
  const char* data;
  size_t dataBytes;

  explicit BlockUpload(const FlatBlock& block) : data((const char*)block.data), dataBytes(block.bytes) {
    if (block.type != gridLeafReferenceType) return;
    std::memcpy(header, data, sizeof(header));
    headerBytes = sizeof(header);
    const size_t skip = sizeof(header) + header[gridOffsetWord];
    header[gridOffsetWord] = 0;
    data += skip;
    dataBytes -= skip;
  }

  size_t bytes() const { return (headerBytes + dataBytes + blockAlignment - 1) & ~size_t(blockAlignment - 1); }
};

/* Returns each block of a surface once. A scene may contain a surface directly and in an instanced scene. */
std::vector<PlacedBlock*> withoutRepeats(const std::vector<PlacedBlock*>& blocks) {
  std::vector<PlacedBlock*> unique;
  std::unordered_set<const void*> found;
  for (PlacedBlock* block : blocks)
    if (found.insert(block->block->source).second) unique.push_back(block);
  return unique;
}

size_t bytesOf(const std::vector<PlacedBlock*>& blocks) {
  size_t bytes = 0;
  for (const PlacedBlock* block : blocks) bytes += BlockUpload(*block->block).bytes();
  return bytes;
}

/* Uploads blocks to few large buffers. expected: upper bound of their bytes. */
class BlockWriter {
public:
  BlockWriter(Device& device, Uploader& uploader, size_t expected)
    : device(device),
      uploader(uploader),
      remaining(expected) {}

  void write(PlacedBlock& placed) {
    requireValid(*placed.block);
    const BlockUpload source(*placed.block);
    if (buffers.empty() || used + source.bytes() > end) addBuffer(source.bytes());
    const Slice slice = {buffers.back().get(), 0};
    if (source.headerBytes) uploader.write(slice, used, source.header, source.headerBytes);
    uploader.write(slice, used + source.headerBytes, source.data, source.dataBytes);
    placed.address = slice.address() + used;
    used += source.bytes();
    remaining -= source.bytes();
  }

  std::vector<std::shared_ptr<Buffer>> buffers;

private:
  void addBuffer(size_t minBytes) {
    const size_t maxBytes = std::min(device.capabilities.maxAllocation, size_t(1) << 30) & ~size_t(blockAlignment - 1);
    end = std::max(std::min(remaining, maxBytes - readPadding), minBytes);
    buffers.emplace_back(new Buffer(device, end + readPadding, Buffer::OnDevice, "blocks"));
    used = 0;
  }

  Device& device;
  Uploader& uploader;
  size_t remaining, used = 0, end = 0;
};

/* blocks: without repeats. */
std::shared_ptr<const UploadedSurface> writeSurface(BlockWriter& writer, const std::vector<PlacedBlock*>& blocks) {
  const auto surface = std::make_shared<UploadedSurface>();
  for (PlacedBlock* block : blocks) {
    writer.write(*block);
    surface->places.push_back({block->block->source, block->address});
    if (surface->buffers.empty() || surface->buffers.back() != writer.buffers.back())
      surface->buffers.push_back(writer.buffers.back());
  }
  std::sort(surface->places.begin(), surface->places.end(),
            [](const UploadedSurface::Place& a, const UploadedSurface::Place& b) {
              return std::less<const void*>()(a.source, b.source);
            });
  return surface;
}

} // namespace

VkDeviceAddress UploadedSurface::addressOf(const void* source) const {
  const auto place = std::lower_bound(places.begin(), places.end(), source, [](const Place& a, const void* b) {
    return std::less<const void*>()(a.source, b);
  });
  return place != places.end() && place->source == source ? place->address : 0;
}

size_t BlockBuffers::bytes() const {
  std::set<std::shared_ptr<Buffer>> buffers(own.begin(), own.end());
  for (const auto& surface : surfaces) buffers.insert(surface->buffers.begin(), surface->buffers.end());
  size_t bytes = 0;
  for (const auto& buffer : buffers) bytes += buffer->bytes;
  return bytes;
}

BlockBuffers importBlocks(Device& device, std::vector<PlacedBlock>& blocks) {
  struct Range {
    size_t begin, end;
  };
  std::vector<Range> ranges;
  const size_t alignment = device.capabilities.importAlignment;
  for (const PlacedBlock& placed : blocks) {
    const FlatBlock& block = *placed.block;
    requireValid(block);
    const size_t begin = size_t(block.data), end = begin + block.bytes + (isReadPastEnd(block) ? readPadding : 0);
    ranges.push_back({begin & ~(alignment - 1), (end + alignment - 1) & ~(alignment - 1)});
  }
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
  const size_t maxBytes = std::min(device.capabilities.maxAllocation, size_t(1) << 30) & ~(alignment - 1);
  std::vector<Range> joined;
  for (const Range& range : ranges) {
    if (!joined.empty() && range.begin <= joined.back().end && range.end - joined.back().begin <= maxBytes)
      joined.back().end = std::max(joined.back().end, range.end);
    else joined.push_back(range);
  }
  BlockBuffers out;
  for (const Range& range : joined) {
    out.own.emplace_back(new Buffer(device, (void*)range.begin, range.end - range.begin));
    out.importedBytes += range.end - range.begin;
  }
  for (PlacedBlock& placed : blocks) {
    const size_t begin = size_t(placed.block->data);
    const size_t r = size_t(std::upper_bound(joined.begin(), joined.end(), begin,
                                             [](size_t at, const Range& range) { return at < range.begin; }) -
                            joined.begin()) -
                     1;
    placed.address = out.own[r]->address + (begin - joined[r].begin);
  }
  return out;
}

BlockBuffers copyBlocks(Device& device, Uploader& uploader, std::vector<PlacedBlock>& blocks) {
  device.uploads.removeExpired();
  std::map<uint64_t, std::vector<PlacedBlock*>> builds;
  for (PlacedBlock& block : blocks) builds[block.buildID].push_back(&block);

  BlockBuffers out;
  std::vector<std::pair<uint64_t, std::vector<PlacedBlock*>>> small;
  size_t smallBytes = 0;
  std::map<uint64_t, std::shared_ptr<const UploadedSurface>> surfaces;
  for (const auto& build : builds) {
    if (build.first == 0) { // grids of GRID, which the tree of one scene contains once
      BlockWriter writer(device, uploader, bytesOf(build.second));
      for (PlacedBlock* block : build.second) writer.write(*block);
      out.own = writer.buffers;
      continue;
    }
    if (const auto surface = device.uploads.find(build.first)) {
      surfaces[build.first] = surface;
      continue;
    }
    const std::vector<PlacedBlock*> unique = withoutRepeats(build.second);
    const size_t bytes = bytesOf(unique);
    if (bytes < ownBufferBytes) {
      small.push_back({build.first, unique});
      smallBytes += bytes;
    } else {
      BlockWriter writer(device, uploader, bytes);
      surfaces[build.first] = writeSurface(writer, unique);
    }
  }
  BlockWriter writer(device, uploader, smallBytes);
  for (const auto& build : small) surfaces[build.first] = writeSurface(writer, build.second);

  uploader.flush(); // before adding surfaces: scenes on other threads may use them at once
  for (const auto& surface : surfaces) {
    for (PlacedBlock* block : builds[surface.first]) block->address = surface.second->addressOf(block->block->source);
    device.uploads.add(surface.first, surface.second);
    out.surfaces.push_back(surface.second);
  }
  return out;
}

} // namespace embree::vulkan
