// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The codec library (kernels/cvert) and Embree's library read each other's files. */

#include "cvert/decoder/decoded_block.h"
#include "cvert/decoder/decoded_mesh.h"
#include "cvert/encoder/block_encoder.h"
#include "cvert/encoder/motion_encoder.h"
#include "cvert/file/file.h"
#include "cvert/file/tree_reader.h"
#include "cvert/file/writer.h"
#include "support/file_mutations.h"
#include "support/message_parts.h"
#include "support/query_forms.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <set>

namespace programs::test { namespace {

using cvert::ErrorCode;

typedef std::array<float, 3> Vertex;

// Vertices of the parts of a geometry at a time, as Embree's library reports them.
std::vector<std::vector<Vertex>> partsOf(RTCGeometry geometry, float time) {
  std::vector<std::vector<Vertex>> parts;
  forEachStoredPart(
      geometry, time,
      [](void* user, const CbvhPart* part) {
        std::vector<Vertex> vertices;
        for (size_t i = 0; i < size_t(part->width) * part->height; i++)
          vertices.push_back({part->vertices[3 * i], part->vertices[3 * i + 1], part->vertices[3 * i + 2]});
        ((std::vector<std::vector<Vertex>>*)user)->push_back(vertices);
        return true;
      },
      &parts);
  return parts;
}

// Compares bits, because raw blocks contain NaN.
bool isSame(const std::vector<Vertex>& vertices, const cvert::DecodedBlock& decoded) {
  return std::memcmp(vertices.data(), decoded.vertices, vertices.size() * sizeof(Vertex)) == 0;
}

// Embree's parts come from the same scalar decoder; tests/isa compares it with the decoders for traversal.
TEST(CodecLibrary, ReadsVerticesThatEmbreeTraces) {
  Folder folder;
  size_t numBlocks = 0;
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    Device device;
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "one").c_str())) << device.message;
    const cvert::File file(folder / "one");
    ASSERT_EQ(file.size(), 1u);
    EXPECT_NO_THROW(file.verify());
    std::vector<const cvert::VertHeader*> blocks;
    bool hasFramed = false;
    std::vector<const cvert::MeshHeader*> meshes;
    const cvert::Reason reason =
        cvert::forEachBlock(file.geometry(0), file.tree(0), [&](cvert::FileChild type, uint64_t offset) {
          if (type == cvert::FILE_FRAMED) hasFramed = true;
          else if (cvert::isMesh(type)) meshes.push_back((const cvert::MeshHeader*)(file.blocks(0) + offset));
          else blocks.push_back((const cvert::VertHeader*)(file.blocks(0) + offset));
        });
    EXPECT_EQ(reason.message(), "");
    if (!hasFramed) {
      EXPECT_EQ(blocks.size() + meshes.size(), file.geometry(0).numBlocks);
      const std::vector<std::vector<Vertex>> parts = partsOf(geometry, file.geometry(0).begin);
      if (meshes.empty()) { ASSERT_EQ(parts.size(), blocks.size()); }
      std::set<Vertex> ofParts, ofMeshes; // primitives of mesh blocks are parts of four vertices
      for (const auto& part : parts)
        if (part.size() == 4) ofParts.insert(part.begin(), part.end());
      for (const cvert::MeshHeader* block : meshes) {
        const auto decoded = std::make_unique<cvert::DecodedMesh>(block);
        for (uint32_t v = 0; v < decoded->numVertices; v++)
          ofMeshes.insert({decoded->vertices[v][0], decoded->vertices[v][1], decoded->vertices[v][2]});
        numBlocks++;
      }
      if (!meshes.empty()) { EXPECT_EQ(ofParts, ofMeshes); }
      std::vector<bool> isFound(parts.size());
      for (const cvert::VertHeader* block : blocks) {
        const auto decoded = std::make_unique<cvert::DecodedBlock>(block);
        size_t i = 0;
        while (i < parts.size() &&
               (isFound[i] || parts[i].size() != size_t(decoded->quadsX + 1) * (decoded->quadsY + 1) ||
                !isSame(parts[i], *decoded)))
          i++;
        ASSERT_LT(i, parts.size()) << "Embree has no such block";
        isFound[i] = true;
        numBlocks++;
      }
    }
    rtcReleaseGeometry(geometry);
  }
  EXPECT_GT(numBlocks, 100u);
}

// A sheet over [0,32] x [0,32] with 2 x 2 blocks of 16 x 16 quads.
struct Sheet {
  static const unsigned quads = 32;
  std::vector<std::vector<uint64_t>> blocks;
  cvert::FileSurface surface;

  explicit Sheet(unsigned numSteps) {
    surface.record.form = numSteps > 1 ? cvert::FILE_MOVING : cvert::FILE_LIST;
    surface.record.source = cvert::FILE_GRIDS;
    surface.record.compression = cvert::FILE_COMPRESSION_VERT;
    surface.record.numPrimitives = 1;
    surface.record.numTimeSteps = numSteps;
    surface.record.end = 1;
    for (unsigned y = 0; y < quads; y += 16)
      for (unsigned x = 0; x < quads; x += 16) add(x, y, numSteps);
  }

  static float heightAt(unsigned x, unsigned y, unsigned step) { return float((x * x + 3 * y) % 7) / 8 + float(step); }

private:
  static void fill(float (*vertices)[3], unsigned x, unsigned y, unsigned step) {
    for (unsigned v = 0; v < 17 * 17; v++) {
      vertices[v][0] = float(x + v % 17);
      vertices[v][1] = float(y + v / 17);
      vertices[v][2] = heightAt(x + v % 17, y + v / 17, step);
    }
  }

  void add(unsigned x, unsigned y, unsigned numSteps) {
    const cvert::VertPlacement place(cvert::packRegion(16, 16, x, y), cvert::packPatchQuads(quads, quads));
    blocks.emplace_back(cvert::MotionEncoder::maxBytes(numSteps) / 8 + 1);
    uint8_t* const data = (uint8_t*)blocks.back().data();
    size_t bytes;
    if (numSteps > 1) {
      const auto encoder = std::make_unique<cvert::MotionEncoder>();
      encoder->begin(place, 0, 1, numSteps, data);
      for (unsigned step = 0; step < numSteps; step++) {
        fill(encoder->vertices(), x, y, step);
        encoder->addStep();
      }
      cvert::MotionStatistics statistics;
      bytes = encoder->finish(statistics);
    } else {
      const auto encoder = std::make_unique<cvert::VertEncoder>();
      fill(encoder->vertices, x, y, 0);
      cvert::VertStatistics statistics;
      bytes = encoder->encode(place, data, statistics);
    }
    surface.appendToList(data, uint32_t(bytes));
  }
};

TEST(CodecLibrary, WritesFilesThatEmbreeTraces) {
  Folder folder;
  for (unsigned numSteps : {1u, 3u}) {
    SCOPED_TRACE(numSteps);
    const std::string path = folder / "sheet";
    {
      Sheet sheet(numSteps);
      cvert::FileWriter writer(path);
      writer.add(sheet.surface);
      writer.commit();
    }
    Device device;
    CbvhFile file = openFile(device, path.c_str());
    ASSERT_TRUE(file) << device.message;
    EXPECT_TRUE(verifyFile(file)) << device.message;
    Scene scene(device);
    attach(scene, loadFromFile(device, file, 0));
    rtcCommitScene(scene);
    for (unsigned y = 0; y < Sheet::quads; y += 3)
      for (unsigned x = 0; x < Sheet::quads; x += 3)
        for (unsigned step = 0; step < numSteps; step++) {
          RTCRayHit ray = makeRay({float(x), float(y), 10}, {0, 0, -1});
          ray.ray.time = numSteps > 1 ? float(step) / float(numSteps - 1) : 0;
          const RTCRayHit r = intersect(scene, ray);
          ASSERT_TRUE(isHit(r)) << x << ", " << y;
          EXPECT_NEAR(10 - r.ray.tfar, Sheet::heightAt(x, y, step), 1e-5) << x << ", " << y << ", step " << step;
          EXPECT_EQ(r.hit.primID, 0u);
          EXPECT_NEAR(r.hit.u, float(x) / Sheet::quads, 1e-6);
          EXPECT_NEAR(r.hit.v, float(y) / Sheet::quads, 1e-6);
        }
    releaseFile(file);
    EXPECT_EQ(device.errors, 0u) << device.message;
  }
}

ErrorCode codeOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const cvert::Error& error) {
    EXPECT_STRNE(error.what(), "");
    return error.code;
  }
  return ErrorCode::NONE;
}

TEST(CodecLibrary, ReportsErrors) {
  Folder folder;
  EXPECT_EQ(codeOf([&] { cvert::File file(folder / "none"); }), ErrorCode::INVALID_ARGUMENT);
  EXPECT_EQ(codeOf([&] { cvert::File file(folder.path); }), ErrorCode::INVALID_ARGUMENT);
  EXPECT_EQ(codeOf([&] { cvert::FileWriter writer(folder / "no/folder"); }), ErrorCode::INVALID_ARGUMENT);
  {
    cvert::FileWriter writer(folder / "empty");
    EXPECT_EQ(codeOf([&] { writer.commit(); }), ErrorCode::INVALID_OPERATION) << "without a geometry";
    EXPECT_EQ(codeOf([&] { writer.requireOpen(); }), ErrorCode::NONE) << "geometries can still be added";
  }
  Sheet sheet(1);
  {
    cvert::FileWriter writer(folder / "sheet");
    writer.add(sheet.surface);
    writer.commit();
    EXPECT_EQ(codeOf([&] { writer.add(sheet.surface); }), ErrorCode::INVALID_OPERATION) << "after a commit";
  }
  const std::string sound = bytesOf(folder / "sheet");
  std::string newer = sound;
  newer[offsetof(cvert::FileHeader, version)] = char(cvert::fileVersion + 1);
  writeBytes(folder / "newer", newer);
  EXPECT_EQ(codeOf([&] { cvert::File file(folder / "newer"); }), ErrorCode::UNSUPPORTED);
  writeBytes(folder / "short", sound.substr(0, sound.size() - 1));
  EXPECT_EQ(codeOf([&] { cvert::File file(folder / "short"); }), ErrorCode::DAMAGED);
  std::string altered = sound;
  altered[2 * 4096 + 100] ^= 1; // in a block; opening a file does not read blocks
  writeBytes(folder / "altered", altered);
  const cvert::File file(folder / "altered");
  EXPECT_EQ(codeOf([&] { file.verify(); }), ErrorCode::DAMAGED);
  FileBytes reserved(sound);
  reserved.record(0).reserved[1] = 1;
  reserved.fitChecksums();
  writeBytes(folder / "reserved", reserved.bytes);
  EXPECT_EQ(codeOf([&] { cvert::File file(folder / "reserved"); }), ErrorCode::UNSUPPORTED);
  FileBytes unknown(sound);
  cvert::FileGeometry& record = unknown.record(0);
  ((cvert::VertHeader*)&unknown.bytes[record.blocks])->corners[4] ^= 1u << 15;
  record.blocksChecksum = crc32c(&unknown.bytes[record.blocks], record.blockBytes);
  unknown.fitChecksums();
  writeBytes(folder / "unknown", unknown.bytes);
  EXPECT_EQ(codeOf([&] { cvert::File(folder / "unknown").verify(); }), ErrorCode::UNSUPPORTED);
  {
    Sheet moving(2);
    cvert::FileWriter writer(folder / "two");
    writer.add(moving.surface);
    writer.add(moving.surface);
    writer.commit();
  }
  const std::string ofTwo = bytesOf(folder / "two");
  FileBytes two(ofTwo);
  two.record(1).surface = two.record(0).surface;
  two.fitChecksums();
  writeBytes(folder / "two", two.bytes);
  EXPECT_EQ(codeOf([&] { cvert::File file(folder / "two"); }), ErrorCode::DAMAGED);
  const auto codeWithBlocks = [&](size_t i, uint64_t blocks, uint64_t blockBytes) {
    FileBytes other(ofTwo);
    other.record(i).blocks = blocks;
    other.record(i).blockBytes = blockBytes;
    other.fitChecksums();
    writeBytes(folder / "two", other.bytes);
    return codeOf([&] { cvert::File file(folder / "two"); });
  };
  const cvert::FileGeometry first = two.record(0), second = two.record(1);
  EXPECT_EQ(codeWithBlocks(1, second.blocks, second.blockBytes), ErrorCode::NONE);
  EXPECT_EQ(codeWithBlocks(1, first.blocks, second.blockBytes), ErrorCode::DAMAGED);
  EXPECT_EQ(codeWithBlocks(1, first.blocks, 16), ErrorCode::DAMAGED);
  EXPECT_EQ(codeWithBlocks(1, 0, first.blocks + 1), ErrorCode::DAMAGED);
  EXPECT_EQ(codeWithBlocks(1, first.blocks, 0), ErrorCode::NONE) << "without blocks";
  EXPECT_EQ(codeWithBlocks(0, first.blocks, second.blocks - first.blocks), ErrorCode::NONE);
  EXPECT_EQ(codeWithBlocks(0, first.blocks, second.blocks - first.blocks + 1), ErrorCode::DAMAGED);

  // blocks
  std::vector<uint64_t> block = sheet.blocks[0];
  cvert::VertHeader* const header = (cvert::VertHeader*)block.data();
  const size_t bytes = 8 * block.size();
  EXPECT_EQ(cvert::validateVert(header, bytes).code, ErrorCode::NONE);
  EXPECT_EQ(cvert::validateVert(header, 63).code, ErrorCode::DAMAGED);
  EXPECT_TRUE(containsInOrder(cvert::validateVert(header, 63).message(), {"63 bytes", "64"}));
  header->corners[4] ^= 1u << 15; // version 4
  EXPECT_NE(cvert::validateVert(header, bytes).message().find("version 4"), std::string::npos);
  EXPECT_EQ(cvert::validateVert(header, bytes).code, ErrorCode::UNSUPPORTED);
  EXPECT_EQ(codeOf([&] { sheet.surface.appendToList(header, uint32_t(bytes)); }), ErrorCode::UNSUPPORTED);
  cvert::FileSurface hasTree;
  EXPECT_EQ(codeOf([&] { hasTree.appendToList(sheet.blocks[0].data(), uint32_t(bytes)); }), ErrorCode::INVALID_ARGUMENT)
      << "the surface is a tree";
}

// Trees of scenes have no part for it: its empty box has no center.
TEST(CodecLibrary, TreeWithoutBlocksIsNoPartOfAScene) {
  Folder folder;
  Sheet sheet(1); // four blocks, which one node contains
  const auto statisticsWith = [&](cvert::FileForm form) {
    cvert::FileSurface empty;
    empty.record = sheet.surface.record;
    empty.record.form = form;
    if (form == cvert::FILE_TREE) empty.tree.resize(sizeof(cvert::FileNode));
    for (int k = 0; k < 3; k++) {
      empty.record.lower[k] = INFINITY;
      empty.record.upper[k] = -INFINITY;
    }
    cvert::FileWriter writer(folder / "two");
    writer.add(sheet.surface);
    writer.add(empty);
    writer.commit();
    Device device;
    CbvhFile file = openFile(device, (folder / "two").c_str());
    EXPECT_TRUE(file) << device.message;
    Scene scene(device);
    for (unsigned i = 0; i < 2; i++) attach(scene, loadFromFile(device, file, i));
    rtcCommitScene(scene);
    EXPECT_TRUE(isHit(intersect(scene, makeRay({5.3f, 20.2f, 10}, {0, 0, -1}))));
    releaseFile(file);
    EXPECT_EQ(device.errors, 0u) << device.message;
    return statisticsOf(scene);
  };
  EXPECT_EQ(statisticsWith(cvert::FILE_TREE).topLevelBytes, statisticsWith(cvert::FILE_LIST).topLevelBytes);
}

TEST(CodecLibrary, TreeWithoutNodesIsRejected) {
  Folder folder;
  cvert::FileSurface surface;
  surface.record = Sheet(1).surface.record;
  surface.record.form = cvert::FILE_TREE;
  try {
    cvert::FileWriter(folder / "tree").add(surface);
    FAIL() << "no error";
  } catch (const cvert::Error& error) {
    EXPECT_EQ(error.code, ErrorCode::INVALID_OPERATION);
    EXPECT_TRUE(containsInOrder(error.what(), {"tree", "nodes"}));
  }
}

// The block is valid, and builders of trees need its box.
TEST(CodecLibrary, MovingBlockWithoutFiniteVertexIsNotHit) {
  const unsigned side = 17, numSteps = 2;
  const cvert::VertPlacement place(cvert::packRegion(16, 16, 0, 0), cvert::packPatchQuads(16, 16));
  std::vector<uint64_t> block(cvert::MotionEncoder::maxBytes(numSteps) / 8 + 1);
  const auto encoder = std::make_unique<cvert::MotionEncoder>();
  encoder->begin(place, 0, 1, numSteps, (uint8_t*)block.data());
  for (unsigned step = 0; step < numSteps; step++) {
    for (unsigned v = 0; v < side * side; v++) {
      encoder->vertices()[v][0] = float(v % side);
      encoder->vertices()[v][1] = float(v / side);
      encoder->vertices()[v][2] = v == 0 ? NAN : float(step); // NaN: the step is stored as floats
    }
    encoder->addStep();
  }
  cvert::MotionStatistics statistics;
  const uint32_t bytes = uint32_t(encoder->finish(statistics));
  cvert::FileSurface surface;
  surface.record.form = cvert::FILE_MOVING;
  surface.record.source = cvert::FILE_GRIDS;
  surface.record.compression = cvert::FILE_COMPRESSION_VERT;
  surface.record.numPrimitives = 1;
  surface.record.numTimeSteps = numSteps;
  surface.record.end = 1;
  surface.appendToList(block.data(), bytes);
  Folder folder;
  const std::string path = folder / "sheet";
  {
    cvert::FileWriter writer(path);
    writer.add(surface);
    writer.commit();
  }
  const auto removeVertices = [&](void* data) {
    const cvert::VertHeader* const header = (const cvert::VertHeader*)data;
    const cvert::VertLayout layout = cvert::vertLayout(header->region, header->info);
    for (unsigned step = 0; step < numSteps; step++) {
      const cvert::StepView view = cvert::viewOfStep(header, layout, step);
      ASSERT_TRUE(cvert::isRaw(view.info));
      const size_t offset = size_t(view.data - (const uint8_t*)data) + view.vertices;
      std::fill_n((float*)((uint8_t*)data + offset), 3 * side * side, NAN);
    }
  };
  FileBytes file(bytesOf(path));
  removeVertices(&file.bytes[file.record(0).blocks]);
  writeBytes(path, file.bytes);
  Device device;
  Scene scene(device);
  RTCGeometry geometry = loadGeometryFile(device, path.c_str());
  ASSERT_NE(geometry, nullptr) << device.message;
  attach(scene, geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  RTCBounds bounds;
  rtcGetSceneBounds(scene, &bounds);
  EXPECT_GT(bounds.lower_x, -1);
  EXPECT_LT(bounds.upper_x, 1) << "the block's origin";
  for (unsigned i = 0; i < 256; i++) {
    RTCRayHit ray = makeRay({float(i % 16) + 0.3f, float(i / 16) + 0.4f, 10}, {0, 0, -1});
    ray.ray.time = float(i) / 255;
    EXPECT_FALSE(isHit(intersect(scene, ray)));
  }
  removeVertices(block.data());
  EXPECT_EQ(codeOf([&] { surface.appendToList(block.data(), bytes); }), ErrorCode::INVALID_ARGUMENT);
}

}} // namespace programs::test
