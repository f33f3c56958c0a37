// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Checksums of the blocks of all generated scenes, for the kinds with frames. The test prints the table, to paste after
 * an intended change. (codec/vert_bytes.cpp has checksums of cVERT for given vertices.)
 *
 * The vertices depend on the machine: Embree normalizes with the processor's approximate reciprocal square root, and
 * the compiler may fuse multiply and add. They have a checksum as well. If the first scene's differs, the test is
 * skipped; other scenes whose vertices differ are not compared. */

#include "building/built_scene.h"
#include "kernels/cbvh/framed/block.h"
#include "scenes/catalogue.h"
#include "support/scene_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <tuple>

namespace cbvh::test {
namespace {

using embree::cbvh::Block;

constexpr int level = 4;

struct Pinned
{
  std::string scene;
  uint64_t vertices;
  uint64_t blocks[3]; // cGRID, cVOXEL, cLEAF, frame level 1
};

const std::vector<Pinned> pinned = {
  {"cube", 0xca4d661345f11e79, {0x575d47c7ae005426, 0xf4eb1252daf06b5e, 0xe84093954d6b2b47}},
  {"frog", 0xbf08fd67ae03b294, {0x6bc56d8d12877b63, 0x7235559163af115d, 0xa239cae17942eed5}},
  {"herd", 0x5b354d433494908d, {0x94ad17447b0388a1, 0x4fdc9bf315f7eef7, 0xacc43bfcde4108c3}},
  {"knee", 0x9e29cd3513541861, {0x8436fbf939870cef, 0x0371576e70dc2f7e, 0x2efb2a99c8d3ebfb}},
  {"scythe", 0x4eb9c880fd45f837, {0xa8b25619416b0c77, 0xe731c3adcc90bc3b, 0x9ba2ea78a1423c7d}},
  {"trex", 0xbad89acd94cc6d43, {0x497ea27d3adf9b81, 0x217dd004d6878535, 0xc7b49010433bfdc8}},
};

class Checksum
{
public:
  void add(const void* data, size_t bytes)
  {
    for (size_t i = 0; i < bytes; i++) value = (value ^ ((const unsigned char*)data)[i])*0x100000001b3u;
  }
  uint64_t value = 0xcbf29ce484222325u;
};

// In an order that does not depend on threads.
std::vector<const Block*> sortedBlocks(RTCScene scene)
{
  std::vector<const Block*> blocks = sceneBlocks(scene);
  const auto key = [](const Block* b) { return std::make_tuple(b->surface, b->primID, b->tiling, b->info); };
  std::sort(blocks.begin(), blocks.end(), [&](const Block* a, const Block* b) { return key(a) < key(b); });
  return blocks;
}

// The patches that all kinds are made of.
struct Source
{
  Model model;
  BuildSettings build;

  explicit Source(const std::string& name)
  {
    SceneSettings settings;
    settings.scene = name;
    settings.mapFolder = MAP_FOLDER;
    if (name == "herd") settings.count = 2;
    std::string warning;
    model = loadScene(settings, warning);
    build.level = level;
  }
};

uint64_t vertexChecksum(const Source& source)
{
  const BuiltScene scene(source.model, {RepresentationKind::CGrid, 1}, source.build);
  Checksum vertices;
  for (const Block* block : sortedBlocks(scene.handle())) vertices.add(block->leaves(), block->layout().leafBytes);
  return vertices.value;
}

Pinned checksums(const std::string& name)
{
  const Source source(name);
  Pinned found = {name, vertexChecksum(source), {}};
  const RepresentationKind kinds[] = {RepresentationKind::CGrid, RepresentationKind::CVoxel,
                                      RepresentationKind::CLeafOnly};
  for (int k = 0; k < 3; k++) {
    const BuiltScene scene(source.model, {kinds[k], 1}, source.build);
    Checksum blocks;
    for (const Block* block : sortedBlocks(scene.handle())) blocks.add(block, block->layout().bytes);
    found.blocks[k] = blocks.value;
  }
  return found;
}

// One test, because trex and herd share a map, which the first of them creates.
TEST(BlockBytes, MatchPinnedChecksums)
{
  if (!PINNED_ISA) GTEST_SKIP() << "checksums exist only for builds whose lowest ISA is SSE2";
  const char* const otherVertices = "Embree evaluates different vertices on this processor";
  const uint64_t ofFirst = vertexChecksum(Source(pinned[0].scene));
  if (ofFirst != pinned[0].vertices)
    GTEST_SKIP() << otherVertices << ": those of " << pinned[0].scene << " have 0x" << std::hex << ofFirst;
  std::string table, others;
  for (const std::string& scene : sceneNames()) {
    SCOPED_TRACE(scene);
    const Pinned found = checksums(scene);
    char row[200];
    std::snprintf(row, sizeof(row),
                  "  {\"%s\", 0x%016" PRIx64 ", {0x%016" PRIx64 ", 0x%016" PRIx64 ", 0x%016" PRIx64 "}},\n",
                  scene.c_str(), found.vertices, found.blocks[0], found.blocks[1], found.blocks[2]);
    table += row;
    const auto expected = std::find_if(pinned.begin(), pinned.end(), [&](const Pinned& p) { return p.scene == scene; });
    if (expected == pinned.end()) { ADD_FAILURE() << "no checksums for this scene"; continue; }
    if (found.vertices != expected->vertices) {
      others += " " + scene;
      continue;
    }
    for (int k = 0; k < 3; k++) {
      EXPECT_EQ(found.blocks[k], expected->blocks[k]) << (k == 0 ? "cGRID" : k == 1 ? "cVOXEL" : "cLEAF");
    }
  }
  std::printf("%s", table.c_str());
  if (!others.empty()) GTEST_SKIP() << otherVertices << ", of:" << others;
}

} // namespace
} // namespace cbvh::test
