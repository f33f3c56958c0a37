// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The moving blocks of a scene, and their boxes per time step: the input of MotionTree. Blocks are decoded
 * unless the boxes that their build computed still exist. */

#include "../blocks/block_table.h"
#include "../exact/motion_decoder.h"
#include "motion_tree.h"
#include "../../cvert/portable/world.h"
#include "../../cvert/decoder/decoded_block.h"
#include "../../cvert/decoder/decoded_mesh.h"
#include "../../cvert/decoder/mesh_tile_view.h"
#include "../blocks/surface_blocks.h"
#include <algorithm>
#include <memory>

namespace embree::isa {
class MovingBlocks {
public:
  explicit MovingBlocks(Device* device) : device(device), blocks(device, 0) {}

  void reserve(size_t numBlocks) { blocks.reserve(numBlocks); }

  /*! Adds the blocks of a surface, unless rays cannot hit it. progress() may throw to cancel. */
  template<typename Progress>
  void add(const SurfaceBlocks& surface, const Progress& progress) {
    if (surface.moving.empty() || !overlapsRayTimes(surface.moving.front())) return;
    const size_t begin = blocks.size();
    blocks.resize(begin + surface.moving.size());
    size_t numBoxes = 0;
    for (size_t i = 0; i < surface.moving.size(); i++) {
      MotionTree::Block& block = blocks[begin + i];
      block.leaf = BVH4::NodeRef(surface.moving[i]);
      const cbvh::VertMotion motion = motionOf(block.leaf);
      block.range = BBox1f(motion.begin, motion.end);
      block.segments = motion.numSteps - 1;
      numBoxes += motion.numSteps;
    }
    Boxes own = std::atomic_load(&surface.boxes);
    if (!own) own = findBoxes(begin, numBoxes, progress);
    boxes.push_back(own);
    size_t n = 0;
    for (size_t i = begin; i < blocks.size(); i++) {
      blocks[i].boxes = own->data() + n;
      n += blocks[i].segments + 1;
    }
  }

  size_t size() const { return blocks.size(); }
  const mvector<MotionTree::Block>& all() const { return blocks; }

private:
  typedef std::shared_ptr<const mvector<cbvh::StepBox>> Boxes;

  /*! Embree's builder supports no blocks outside of the times of rays, 0 to 1. */
  static bool overlapsRayTimes(BVH4::NodeRef leaf) {
    const cbvh::VertMotion motion = motionOf(leaf);
    return motion.begin <= 1.0f && motion.end >= 0.0f;
  }

  /*! Computes the boxes of the blocks from `begin` to the last one. numBoxes: sum of their steps. */
  template<typename Progress>
  Boxes findBoxes(size_t begin, size_t numBoxes, const Progress& progress) const {
    std::shared_ptr<mvector<cbvh::StepBox>> found = std::make_shared<mvector<cbvh::StepBox>>(device, numBoxes);
    std::vector<size_t> firsts; // index of the first box of every 64 blocks
    size_t n = 0;
    for (size_t i = begin; i < blocks.size(); i++) {
      if ((i - begin) % 64 == 0) firsts.push_back(n);
      n += blocks[i].segments + 1;
    }
    parallel_for(size_t(0), firsts.size(), [&](const range<size_t>& r) {
      std::unique_ptr<BoundsDecoder> boundsDecoder(new BoundsDecoder);
      for (size_t k = r.begin(); k != r.end(); k++) {
        size_t at = firsts[k];
        for (size_t i = begin + 64 * k; i < min(begin + 64 * (k + 1), blocks.size()); i++) {
          boundsDecoder->decode(blocks[i].leaf, blocks[i].segments, found->data() + at);
          at += blocks[i].segments + 1;
        }
        progress();
      }
    });
    return found;
  }

  static cbvh::VertMotion motionOf(BVH4::NodeRef leaf) {
    size_t type;
    const void* const block = leaf.leaf(type);
    return cbvh::rowOf(cbvh::BlockType(type)).motion(block);
  }

  /*! Computes boxes of blocks. On the heap, because it is large. */
  class alignas(64) BoundsDecoder {
    ALIGNED_CLASS_(64);

  public:
    /*! boxes: output, one per step. */
    void decode(BVH4::NodeRef leaf, unsigned segments, cbvh::StepBox* boxes) {
      size_t type;
      const void* const block = leaf.leaf(type);
      const float* origin = nullptr;
      switch (cbvh::BlockType(type)) {
      case cbvh::VERT_BLOCK:
        decodeGrid((const cbvh::VertHeader*)block, segments, boxes);
        origin = ((const cbvh::VertHeader*)block)->origin;
        break;
      case cbvh::MESH_BLOCK:
        decodeMesh((const cbvh::MeshHeader*)block, segments, boxes);
        origin = ((const cbvh::MeshHeader*)block)->origin;
        break;
      case cbvh::TILE_BLOCK:
        if (cbvh::isMeshTile(block)) {
          decodeMeshTile((const cbvh::MeshTileHeader*)block, segments, boxes);
          origin = cbvh::meshTileOfStep((const cbvh::MeshTileHeader*)block, 0)->origin;
          break;
        }
        for (unsigned s = 0; s <= segments; s++) boxes[s] = boundStep((const cbvh::VertHeader*)block, s);
        origin = cbvh::tileOfStep((const cbvh::VertHeader*)block, 0)->origin;
        break;
      case cbvh::FRAMED_BLOCK: throw_RTCError(RTC_ERROR_UNKNOWN, "a block with a frame moves");
      }
      // MotionTree requires a box
      if (std::all_of(boxes, boxes + segments + 1, [](const cbvh::StepBox& box) { return box.isEmpty(); }))
        for (int k = 0; k < 3; k++) boxes[0].lower[k] = boxes[0].upper[k] = origin[k];
    }

  private:
    static void decodeMesh(const cbvh::MeshHeader* block, unsigned segments, cbvh::StepBox* boxes) {
      for (unsigned s = 0; s <= segments; s++) {
        const cbvh::DecodedMesh mesh(block, s);
        boxes[s] = emptyBox();
        for (uint32_t v = 0; v < mesh.numVertices; v++) extend(boxes[s], mesh.vertices[v]);
      }
    }

    static void decodeMeshTile(const cbvh::MeshTileHeader* tile, unsigned segments, cbvh::StepBox* boxes) {
      for (unsigned s = 0; s <= segments; s++) {
        const cbvh::MeshTileView step(cbvh::meshTileOfStep(tile, s));
        boxes[s] = emptyBox();
        for (uint32_t g = 0; g < step.groups; g++)
          for (uint32_t v = 0; v < cbvh::tileGroupVertices(step.record(g)); v++) {
            float p[3];
            step.vertex(g, v, p);
            extend(boxes[s], p);
          }
      }
    }

    static cbvh::StepBox emptyBox() { return {{pos_inf, pos_inf, pos_inf}, {neg_inf, neg_inf, neg_inf}}; }

    static void extend(cbvh::StepBox& box, const float (&p)[3]) {
      if (!cbvh::isFinite(p)) return; // the block is damaged
      for (int k = 0; k < 3; k++) {
        box.lower[k] = min(box.lower[k], p[k]);
        box.upper[k] = max(box.upper[k], p[k]);
      }
    }

    /*! Decodes both steps of every second segment and of the last one, with traversal's decoder where possible. */
    void decodeGrid(const cbvh::VertHeader* block, unsigned segments, cbvh::StepBox* boxes) {
      for (unsigned s = 0; s <= segments; s += 2) {
        const unsigned segment = min(s, segments - 1);
        cbvh::MotionDecoder decoder(block);
        if (decoder.isRaw(segment) || decoder.isRaw(segment + 1)) {
          for (unsigned e = 0; e < 2; e++) boxes[segment + e] = boundStep(block, segment + e);
          continue;
        }
        segmentEntry.key = {block, segment, 0};
        decoder.decode(segment, segmentEntry);
        Bounds bounds[2];
        for (uint32_t rest = segmentEntry.lanes; rest; rest &= rest - 1) {
          decoder.vertices(segmentEntry, uint32_t(bsf(rest)), group);
          for (unsigned e = 0; e < 2; e++) bounds[e].extend(group.vertices[e]);
        }
        for (unsigned e = 0; e < 2; e++) boxes[segment + e] = bounds[e].box();
      }
    }

    struct Bounds {
      vfloat4 lower[3] = {pos_inf, pos_inf, pos_inf}, upper[3] = {neg_inf, neg_inf, neg_inf};

      void extend(const cbvh::CellVertices& v) {
        for (int k = 0; k < 3; k++) {
          const vfloat4 last(v.at[k][cbvh::cellVertices - 1]);
          lower[k] = min(lower[k], last);
          upper[k] = max(upper[k], last);
          for (int l = 0; l < cbvh::cellVertices - 1; l += 4) {
            const vfloat4 x = vfloat4::load(v.at[k] + l);
            lower[k] = min(lower[k], x);
            upper[k] = max(upper[k], x);
          }
        }
      }

      cbvh::StepBox box() const {
        cbvh::StepBox box;
        for (int k = 0; k < 3; k++) {
          box.lower[k] = reduce_min(lower[k]);
          box.upper[k] = reduce_max(upper[k]);
        }
        return box;
      }
    };

    /*! For tiles, and for segments with a raw end: traversal's decoder omits groups without a finite vertex at one of
     * the ends, but the box of the other end is also used in another segment. */
    static cbvh::StepBox boundStep(const cbvh::VertHeader* block, unsigned step) {
      cbvh::StepBox box;
      cbvh::DecodedBlock(block, step).bounds(box.lower, box.upper);
      return box;
    }

    cbvh::VertSegmentEntry segmentEntry;
    cbvh::SegmentVertices group;
  };

  Device* const device;
  mvector<MotionTree::Block> blocks;
  std::vector<Boxes> boxes; //!< keeps the boxes of the blocks alive
};
} // namespace embree::isa
