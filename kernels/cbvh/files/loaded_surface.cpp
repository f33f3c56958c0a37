// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the lowest ISA of the library (files.cmake). */

#include "loaded_surface.h"
#include "../base/block_bytes.h"
#include "../base/thread_cache.h"
#include "../embree/scene.h"
#include "../blocks/surface_blocks.h"
#include "../blocks/surface_conversion.h"
#include "../blocks/tree.h"
#include "../../cvert/file/tree_reader.h"
#include "file_statistics.h"
#include "mapped_blocks.h"
#include "validate_framed.h"
#include <new>
#include <sys/mman.h>
#include <unistd.h>

namespace embree::cbvh {
namespace {
/*! Copy-on-write mapping of a part of a file. It begins `offsetInPage` bytes before the part: 0 unless the
 *  machine's pages are larger than the file's, as on some ARM64 machines. */
struct PrivatePages {
  const size_t offsetInPage;
  char* const data;
  const size_t bytes;

  PrivatePages(int file, uint64_t offset, size_t bytes)
    : offsetInPage(size_t(offset % uint64_t(::sysconf(_SC_PAGESIZE)))),
      data((char*)::mmap(nullptr, offsetInPage + bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_NORESERVE, file,
                         off_t(offset - offsetInPage)) +
           offsetInPage),
      bytes(bytes) {
    if (data - offsetInPage == MAP_FAILED) throw std::bad_alloc();
  }
  ~PrivatePages() { ::munmap(data - offsetInPage, offsetInPage + bytes); }
};

/*! Memory of a loaded surface's blocks: private pages, or the mapping of the file if pages is null. */
struct FileAndPages {
  std::shared_ptr<const File> file;
  std::unique_ptr<PrivatePages> pages;
};

/*! True if surfaces of a file become tiles when they are loaded: if tiles are the device's form, a commit does
 *  not choose it, and those of the whole file take at most half of the machine's memory. */
bool makesTiles(const CompressionSettings& settings, const File& file) {
  if (settings.compression != RTC_COMPRESSION_CTILE || settings.memory) return false;
  double bytes = 0;
  for (size_t i = 0; i < file.size(); i++) {
    const FileGeometry& geometry = file.geometry(i);
    bytes += double(geometry.numBlocks) * double(geometry.numTimeSteps) * double(expectedTileBytes);
  }
  return bytes <= 0.5 * double(::sysconf(_SC_PHYS_PAGES)) * double(::sysconf(_SC_PAGESIZE));
}

BBox3fa boundsOf(const float lower[3], const float upper[3]) {
  return BBox3fa(Vec3fa(lower[0], lower[1], lower[2]), Vec3fa(upper[0], upper[1], upper[2]));
}

/*! Sink of TreeReader: builds the same tree from Embree's nodes, or stores a list's entries. */
class SurfaceLoader {
public:
  typedef BVH4::NodeRef Ref;

  SurfaceLoader(const File& file, size_t i, const MappedBlocks& mapped, SurfaceBlocks& surface)
    : file(file),
      i(i),
      mapped(mapped),
      surface(surface) {
    const FileGeometry& record = file.geometry(i);
    if (record.form == FILE_TREE)
      surface.memory.reserve(0, size_t(record.treeBytes / sizeof(FileNode)) * sizeof(BVH4::AABBNode));
  }

  Ref leaf(FileChild child, uint64_t offset) {
    const bool moves = file.geometry(i).form == FILE_MOVING;
    const BlockType type = blockTypeOf(child, moves);
    if (moves) // checked now, because the commit of a scene decodes its boxes
      if (const Reason reason = mapped.accept(size_t(offset), type))
        file.fail(i, "the block at " + std::to_string(offset) + ": ", reason);
#if defined(EMBREE_CBVH_NO_PAPER)
    if (type == FRAMED_BLOCK)
      file.failUnsupported(i, "it has blocks with frames: expected a library that was built with the paper's "
                              "representations");
#endif
    surface.types |= 1u << type;
    return BVH4::encodeTypedLeaf((void*)(mapped.first() + offset), type);
  }

  BVH4::AABBNode* beginNode() {
    BVH4::AABBNode* const node = (BVH4::AABBNode*)surface.memory.pool()->getCachedAllocator().malloc0(
        sizeof(BVH4::AABBNode), BVH4::byteNodeAlignment);
    node->clear();
    return node;
  }

  static void setChild(BVH4::AABBNode* node, unsigned i, const float lower[3], const float upper[3], Ref ref) {
    node->setBounds(i, boundsOf(lower, upper));
    node->setRef(i, ref);
  }

  static Ref endNode(BVH4::AABBNode* node) { return BVH4::encodeNode(node); }

  void entry(const FileEntry& entry, Ref ref) {
    if (file.geometry(i).form == FILE_MOVING) surface.moving.push_back(ref);
    else surface.parts.push_back(PrimRef(boundsOf(entry.lower, entry.upper), size_t(ref)));
  }

private:
  const File& file;
  const size_t i;
  const MappedBlocks& mapped;
  SurfaceBlocks& surface;
};
static_assert(TreeReader<SurfaceLoader>::maxDepth <= BVH4::maxBuildDepthLeaf,
              "traversal supports the depth of trees in files");
} // namespace

std::shared_ptr<const SurfaceBlocks> loadSurface(const std::shared_ptr<const File>& file, Device* device, size_t i) {
  const FileGeometry& record = file->geometry(i);
  const uint32_t moving = record.surface & movingSurface;
  const auto number = std::make_shared<const SurfaceNumber>(record.surface & ~movingSurface);
  const std::shared_ptr<SurfaceBlocks> surface = std::make_shared<SurfaceBlocks>(device, number);
  const uint32_t ownNumber = *number | moving;

  /* Blocks contain a surface number (base/surface_ids.h). If another surface has the number of the file, this
   * surface gets a different one, and copy-on-write pages to store it. */
  std::shared_ptr<FileAndPages> memory = std::make_shared<FileAndPages>();
  memory->file = file;
  char* first = (char*)file->blocks(i);
  if (ownNumber != record.surface && record.blockBytes) {
    memory->pages.reset(
        new PrivatePages(file->descriptor(), record.blocks, size_t(record.blockBytes + fileReadPadding)));
    first = memory->pages->data;
  }
  const std::shared_ptr<const File> owner(memory, file.get());
  const std::shared_ptr<const MappedBlocks> mapped = std::make_shared<MappedBlocks>(
      device, owner, first, record, ownNumber, file->path + ": geometry " + std::to_string(i));
  surface->mapped = mapped;
  surface->bounds = areBounds(record.lower, record.upper) ? boundsOf(record.lower, record.upper) : BBox3fa(empty);
  surface->numPrimRefs = size_t(record.numBlocks);
  surface->statistics = statisticsOf(record);
  SurfaceLoader loader(*file, i, *mapped, *surface);
  BVH4::NodeRef root;
  TreeReader<SurfaceLoader> reader(record, file->tree(i), loader);
  if (const Reason reason = reader.read(root)) file->fail(i, "", reason);
  if (record.form == FILE_TREE) {
    surface->root = isa::moveLargestNodes(root, size_t(reader.numNodes()), *surface->memory.pool());
    isa::TreeCutter(surface->parts).cut(surface->root, surface->bounds);
  }
  surface->finish();
  invalidateThreadCaches(); // other blocks may have had these addresses
  if (!makesTiles(device->compression, *file) || !isConvertible(*surface)) return surface;
  return convertSurface(device, surface, TILE_BLOCK, [] {});
}

void verifyFile(const File& file) {
  file.verify([](const FileGeometry& record, const void* block, size_t bytes) {
    const Reason reason = validateFramedInFile(record, block, bytes);
    return !reason && ((const BlockHeader*)block)->surface != record.surface
               ? Reason::damaged("its surface number differs from its geometry's")
               : reason;
  });
}
} // namespace embree::cbvh
