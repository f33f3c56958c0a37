// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Damaged files of compressed geometry, and disks that reject writes. */

#include "kernels/cbvh/paper/block.h"
#include "support/child_process.h"
#include "support/file_calls.h"
#include "support/file_mutations.h"
#include "support/message_parts.h"
#include "support/random_rounds.h"
#include "support/surface_access.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>

namespace programs::test { namespace {

// A cVERT block of floats: a sheet of quads at z = 0, and boxes that are larger by `margin`. A moving block has two
// equal time steps.
std::string rawBlock(const cvert::VertHeader& header, float x, float size, float margin) {
  using namespace cvert;
  const VertLayout layout = vertLayout(header.region, header.info);
  const unsigned quads = vertQuadsX(header.region);
  std::vector<float> vertices, boxes;
  for (unsigned j = 0; j <= quads; j++)
    for (unsigned i = 0; i <= quads; i++)
      vertices.insert(vertices.end(), {x + size * float(i) / float(quads), size * float(j) / float(quads), 0});
  for (float plane : {x - margin, -margin, -margin, x + size + margin, size + margin, margin})
    boxes.insert(boxes.end(), layout.groups, plane);
  std::string bytes;
  const auto append = [&](const void* data, size_t count) { bytes.append((const char*)data, count); };
  append(&header, sizeof(header));
  const VertMotion motion = {0, 1, 2, layout.rawBytes};
  if (isMoving(header.info)) append(&motion, sizeof(motion));
  append(vertices.data(), vertices.size() * sizeof(float));
  append(boxes.data(), boxes.size() * sizeof(float));
  if (!isMoving(header.info)) return bytes;
  const uint32_t offset = uint32_t(bytes.size() + sizeof(offset));
  VertStep step = {};
  step.info = rawInfo;
  append(&offset, sizeof(offset));
  append(&step, sizeof(step));
  append(vertices.data(), vertices.size() * sizeof(float));
  return bytes;
}

// Traces a ray in a new thread, which has no decoded blocks.
RTCRayHit intersectUncached(RTCScene scene, const RTCRayHit& ray) {
  RTCRayHit traced;
  std::thread([&] { traced = intersect(scene, ray); }).join();
  return traced;
}

class DamagedFiles : public testing::Test {
protected:
  DamagedFiles() {
    RTCGeometry geometry = allSaveable()[0].make(device);
    EXPECT_TRUE(saveGeometryFile(geometry, path.c_str()));
    rtcReleaseGeometry(geometry);
    sound = bytesOf(path);
  }

  void expectError(const std::string& file, std::vector<std::string> parts) {
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    parts.insert(parts.begin(), file);
    EXPECT_TRUE(containsInOrder(device.message, parts));
  }

  void expectRefused(const std::string& bytes, const std::vector<std::string>& parts) {
    writeBytes(path, bytes);
    EXPECT_EQ(loadGeometryFile(device, path.c_str()), nullptr);
    expectError(path, parts);
  }

  void loadInto(RTCScene scene) {
    RTCGeometry geometry = loadGeometryFile(device, path.c_str());
    ASSERT_NE(geometry, nullptr) << device.message;
    attach(scene, geometry);
    rtcCommitScene(scene);
    device.errors = 0;
  }

  // Writes a file with two blocks: a sheet over the unit square and, in its bytes at innerOffset, a quad at x = -11
  // to -10. The quad's surface number is also the z of vertex 2 of the sheet: about 2 in the file, and almost 0 if the
  // library replaces the number.
  void writeBlockInAnotherOne(bool moves) {
    using namespace cvert;
    FileBytes file(sound);
    FileGeometry& record = file.record(0);
    record.form = moves ? FILE_MOVING : FILE_LIST;
    record.surface = firstFileNumber | 12345 | (moves ? movingSurface : 0);
    record.numTimeSteps = moves ? 2 : 1;
    record.begin = 0;
    record.end = 1;
    record.numBlocks = 2;
    VertHeader header = {};
    header.surface = record.surface;
    header.info = rawInfo | (moves ? 1u << 31 : 0);
    header.corners[4] = header.corners[5] = 1u << 15; // version 5
    header.region = packRegion(16, 16, 0, 0);
    header.patchQuads = packPatchQuads(16, 16);
    std::string blocks = rawBlock(header, 0, 1, 20);
    innerOffset = vertLayout(header.region, header.info).vertices + 16;
    header.region = packRegion(1, 1, 0, 0);
    header.patchQuads = packPatchQuads(1, 1);
    header.origin[2] = 2 / 16.0f; // x of vertex 2; the two numbers before are y and z of vertex 1
    const std::string inner = rawBlock(header, -11, 1, 0.1f);
    blocks.replace(innerOffset, inner.size(), inner);
    ASSERT_EQ(versionOfCorners(header.corners[4], header.corners[5]), vertFormatVersion);
    ASSERT_LE(blocks.size(), record.blockBytes);
    file.bytes.replace(record.blocks, blocks.size(), blocks);

    const uint64_t type = moves ? FILE_MOVING_VERT : FILE_VERT;
    const FileEntry entries[] = {{{-1, -1, -12}, {2, 2, 3}, type},
                                 {{-11.5f, -0.5f, -0.5f}, {-9.5f, 1.5f, 0.5f}, innerOffset | type}};
    const float lower[] = {-12, -1, -12}, upper[] = {2, 2, 3};
    std::copy(lower, lower + 3, record.lower);
    std::copy(upper, upper + 3, record.upper);
    ASSERT_LE(sizeof(entries), record.treeBytes);
    record.treeBytes = sizeof(entries);
    std::memcpy(&file.bytes[record.tree], entries, sizeof(entries));
    file.fitChecksums();
    writeBytes(path, file.bytes);
  }

  Folder folder;
  Device device;
  size_t innerOffset = 0;
  const std::string path = folder / "surface.cbvh";
  std::string sound;
};

TEST_F(DamagedFiles, AreRejectedWithTheReason) {
  expectRefused("", {" 0 bytes"});
  expectRefused("mesh", {" 4 bytes"});
  expectRefused(std::string(100000, 'x'), {"surfaces"});
  const auto sizes = [&](size_t bytes) {
    return std::vector<std::string>{" " + std::to_string(bytes) + " bytes", " " + std::to_string(sound.size())};
  };
  for (size_t bytes = 64; bytes < sound.size(); bytes += 1 + sound.size() / 50)
    expectRefused(sound.substr(0, bytes), sizes(bytes));
  expectRefused(sound.substr(0, sound.size() - 1), sizes(sound.size() - 1));
  expectRefused(sound + "x", sizes(sound.size() + 1));
  expectRefused("\r" + sound, {"surfaces"});
  std::remove(path.c_str());
  EXPECT_EQ(openFile(device, path.c_str()), nullptr);
  expectError(path, {std::strerror(ENOENT)});
  EXPECT_EQ(openFile(device, folder.path.c_str()), nullptr);
  expectError(folder.path, {"folder", "regular"});
}

TEST_F(DamagedFiles, OtherVersionsAreRejected) {
  FileBytes file(sound);
  const auto with = [&](auto member, uint32_t value) {
    FileBytes other(sound);
    other.header().*member = value;
    other.fitHeader();
    return other.bytes;
  };
  using Header = cvert::FileHeader;
  const auto expectVersion = [&](auto member, const std::string& of, uint32_t value, uint32_t accepted) {
    expectRefused(with(member, value), {of, " " + std::to_string(value), " " + std::to_string(accepted)});
  };
  const Header& header = file.header();
  expectVersion(&Header::version, "files", header.version + 1, header.version);
  expectVersion(&Header::version, "files", header.version - 1, header.version);
  expectVersion(&Header::vertVersion, "cVERT", cvert::movingMeshFormatVersion + 1, cvert::movingMeshFormatVersion);
  expectVersion(&Header::vertVersion, "cVERT", header.vertVersion - 1, header.vertVersion);
  expectVersion(&Header::framedVersion, "frames", header.framedVersion + 1, header.framedVersion);
  expectRefused(with(&Header::byteOrder, __builtin_bswap32(header.byteOrder)), {"little-endian"});
}

TEST_F(DamagedFiles, AnyModifiedByteIsDetected) {
  Random random(21);
  FileBytes file(sound);
  const auto& record = file.record(0);
  const auto alter = [&](size_t begin, size_t end, size_t count, bool isRefused) {
    for (size_t i = 0; i < count; i++) {
      std::string bytes = sound;
      bytes[count >= end - begin ? begin + i % (end - begin) : begin + random.below(uint32_t(end - begin))] ^=
          char(1 << random.below(8));
      if (isRefused) {
        expectRefused(bytes, {});
        continue;
      }
      writeBytes(path, bytes);
      CbvhFile opened = openFile(device, path.c_str());
      ASSERT_NE(opened, nullptr) << device.message;
      EXPECT_FALSE(verifyFile(opened));
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
      releaseFile(opened);
    }
  };
  alter(0, sizeof(cvert::FileHeader), sizeof(cvert::FileHeader), true);
  alter(file.header().directory, sound.size(), sound.size() - file.header().directory, true);
  alter(record.tree, record.tree + record.treeBytes, 300, true);
  alter(record.blocks, record.blocks + record.blockBytes, 100, false);
}

TEST_F(DamagedFiles, InvalidBlockIsLeftOutWithOneError) {
  Random random(5);
  const std::vector<RTCRayHit> rays = raysAt(random, 400);
  const auto trace = [&] {
    Scene scene(device);
    RTCGeometry geometry = loadGeometryFile(device, path.c_str());
    EXPECT_NE(geometry, nullptr) << device.message;
    if (geometry) attach(scene, geometry);
    rtcCommitScene(scene);
    return closestHits(scene, rays, QueryForm::Single);
  };
  const std::vector<RTCRayHit> before = trace();
  FileBytes file(sound);
  const auto& record = file.record(0);
  // replaces primitive 3 of the cube by a primitive that does not exist
  size_t altered = 0;
  for (uint64_t i = 0; i < record.treeBytes; i += 8) {
    uint64_t child;
    std::memcpy(&child, &file.bytes[record.tree + i], sizeof(child));
    if (i % 128 >= 32 || (child & 15) != cvert::FILE_VERT) continue;
    cvert::VertHeader& block = *(cvert::VertHeader*)&file.bytes[record.blocks + (child & ~uint64_t(15))];
    if (block.primID == 3) {
      block.primID = record.numPrimitives;
      altered++;
    }
  }
  ASSERT_GT(altered, 4u);
  writeBytes(path, file.bytes);
  device.errors = 0;
  const std::vector<RTCRayHit> after = trace();
  EXPECT_EQ(device.errors, 1u);
  expectError(path, {"geometry 0:", "primitive 6 ", " 6"});
  size_t others = 0;
  for (size_t i = 0; i < rays.size(); i++) {
    if (isHit(after[i])) { ASSERT_NE(after[i].hit.primID, 3u); }
    if (!isHit(before[i]) || before[i].hit.primID == 3) continue;
    others++;
    ASSERT_EQ(after[i].hit.primID, before[i].hit.primID);
    ASSERT_EQ(after[i].ray.tfar, before[i].ray.tfar);
  }
  EXPECT_GT(others, 100u);
}

// As left by a failed disk: blocks are invalid, and any query reports them.
TEST_F(DamagedFiles, PageOfZerosIsReported) {
  Random random(6);
  const std::vector<RTCRayHit> rays = raysAt(random, 3000);
  for (const Saveable& saveable : allSaveable()) {
    if (saveable.moves) continue; // validated when the file is opened
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, path.c_str()));
    rtcReleaseGeometry(geometry);
    FileBytes file(bytesOf(path));
    const size_t bytes = std::min<size_t>(4096, file.record(0).blockBytes),
                 first = file.record(0).blocks + (file.record(0).blockBytes - bytes) / 2 / 16 * 16;
    std::fill_n(file.bytes.begin() + ptrdiff_t(first), bytes, '\0');
    writeBytes(path, file.bytes);
    for (QueryForm form : {QueryForm::Single, QueryForm::Packet8, QueryForm::CoherentStream}) {
      SCOPED_TRACE(testing::Message() << saveable.name << ", " << nameOf(form));
      Scene scene(device);
      loadInto(scene);
      closestHits(scene, rays, form);
      EXPECT_EQ(device.errors, 1u);
      expectError(path, {"geometry 0:", "damaged"});
      CbvhFile opened = openFile(device, path.c_str());
      ASSERT_NE(opened, nullptr) << device.message;
      EXPECT_FALSE(verifyFile(opened));
      releaseFile(opened);
    }
  }
}

// Parameters of hits depend on the position of the patch in its face.
TEST_F(DamagedFiles, BlockOutsideOfItsFaceIsLeftOut) {
  Random random(7);
  const std::vector<RTCRayHit> rays = raysAt(random, 2000);
  for (RTCCompression compression : {RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CGRID})
    for (const auto& [u, v] :
         {std::make_pair(150u, 0u), std::make_pair(0u, 2u), std::make_pair(17u, 1u), std::make_pair(1u, 0u)}) {
      SCOPED_TRACE(testing::Message() << kindName(compression) << " at " << u << ", " << v);
      SurfaceSettings settings;
      settings.rate = 16;
      RTCGeometry geometry = releasing(newSurface(device, cubeCage(), settings), compression, 0, 0);
      ASSERT_TRUE(saveGeometryFile(geometry, path.c_str()));
      rtcReleaseGeometry(geometry);
      FileBytes file(bytesOf(path));
      const auto& record = file.record(0);
      const size_t stride = record.blockBytes / 6;
      for (size_t i = 0; i < 6; i++) {
        embree::cbvh::BlockHeader& block = *(embree::cbvh::BlockHeader*)&file.bytes[record.blocks + i * stride];
        block.tiling = embree::cbvh::blockTiling(0, 0, u, v);
      }
      writeBytes(path, file.bytes);
      Scene scene(device);
      loadInto(scene);
      for (const RTCRayHit& hit : closestHits(scene, rays, QueryForm::Single)) ASSERT_FALSE(isHit(hit));
      EXPECT_EQ(device.errors, 1u);
      expectError(path, {"geometry 0:", "(" + std::to_string(u) + "/2," + std::to_string(v) + "/2)"});
    }
}

// The owner of a block is found by its address, which must not lead to a geometry without blocks.
TEST_F(DamagedFiles, GeometryWithoutBlocksHidesNoDamageOfAnother) {
  RTCGeometry geometry = loadGeometryFile(device, path.c_str());
  CbvhFileWriter writer = newFileWriter(device, path.c_str());
  for (int i = 0; i < 2; i++) { ASSERT_TRUE(appendGeometry(writer, geometry)) << device.message; }
  ASSERT_TRUE(commitWriter(writer)) << device.message;
  releaseWriter(writer);
  rtcReleaseGeometry(geometry);
  FileBytes file(bytesOf(path));
  cvert::FileGeometry& empty = file.record(0);
  const cvert::FileGeometry& other = file.record(1);
  empty.form = cvert::FILE_LIST;
  empty.treeBytes = empty.blockBytes = empty.numBlocks = 0;
  empty.blocks = other.blocks;
  std::fill_n(file.bytes.begin() + ptrdiff_t(other.blocks), other.blockBytes, '\0');
  file.fitChecksums();
  writeBytes(path, file.bytes);
  Random random(9);
  CbvhFile opened = openFile(device, path.c_str());
  ASSERT_NE(opened, nullptr) << device.message;
  Scene scene(device);
  for (unsigned i = 0; i < 2; i++) attach(scene, loadFromFile(device, opened, i));
  rtcCommitScene(scene);
  device.errors = 0;
  for (const RTCRayHit& hit : closestHits(scene, raysAt(random, 400), QueryForm::Single)) ASSERT_FALSE(isHit(hit));
  EXPECT_EQ(device.errors, 1u);
  expectError(path, {"geometry 1:", "damaged"});
  releaseFile(opened);
}

// A surface number would be written into the inner block, and so into the outer one, which may be in use.
TEST_F(DamagedFiles, BlocksThatOverlapDoNotChangeEachOther) {
  ASSERT_NO_FATAL_FAILURE(writeBlockInAnotherOne(false));
  RTCGeometry owner = loadGeometryFile(device, path.c_str()); // has the file's surface number
  ASSERT_NE(owner, nullptr) << device.message;
  const RTCRayHit rays[] = {makeRay({1.7f / 16, 0.2f / 16, 10}, {0, 0, -1}), makeRay({-10.75f, 0.25f, 10}, {0, 0, -1})};
  for (unsigned first : {0u, 1u}) { // the outer block is reached first, or the inner one
    SCOPED_TRACE(first);
    Scene scene(device);
    loadInto(scene);
    if (HasFatalFailure()) break;
    const RTCRayHit before = intersectUncached(scene, rays[first]);
    ASSERT_TRUE(isHit(before));
    EXPECT_EQ(before.ray.tfar < 9.5f, first == 0) << before.ray.tfar; // near vertex 2 of the sheet
    EXPECT_EQ(device.errors, 0u) << device.message;
    EXPECT_FALSE(isHit(intersectUncached(scene, rays[1 - first])));
    EXPECT_EQ(device.errors, 1u);
    expectError(path, {"geometry 0:", " " + std::to_string(first == 0 ? innerOffset : 0) + " ", "overlap"});
    const RTCRayHit after = intersectUncached(scene, rays[first]);
    EXPECT_EQ(after.hit.geomID, before.hit.geomID);
    EXPECT_EQ(after.ray.tfar, before.ray.tfar);
    EXPECT_EQ(device.errors, 1u);
  }
  rtcReleaseGeometry(owner);
}

// Moving blocks are checked when they are loaded.
TEST_F(DamagedFiles, MovingBlocksThatOverlapAreRejected) {
  ASSERT_NO_FATAL_FAILURE(writeBlockInAnotherOne(true));
  RTCGeometry owner = loadGeometryFile(device, path.c_str()); // has the file's surface number
  ASSERT_NE(owner, nullptr) << device.message;
  EXPECT_EQ(loadGeometryFile(device, path.c_str()), nullptr);
  expectError(path, {"geometry 0:", " " + std::to_string(innerOffset) + ":", "overlap"});
  rtcReleaseGeometry(owner);
}

TEST_F(DamagedFiles, CountsThatContradictEachOtherArePrintedWithoutOverflow) {
  FileBytes file(sound);
  file.record(0).counts[14] = 5; // numMeshQuads
  file.record(0).counts[15] = 9; // numIrregularQuads
  file.fitChecksums();
  writeBytes(path, file.bytes);
  Device verbose("verbose=1");
  RTCGeometry geometry = loadGeometryFile(verbose, path.c_str());
  ASSERT_NE(geometry, nullptr) << verbose.message;
  testing::internal::CaptureStderr();
  {
    Scene scene(verbose);
    attach(scene, geometry);
    rtcCommitScene(scene);
  }
  const std::string output = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(containsInOrder(lineWith(output, " of 5 quads"), {" 0 of 5 quads", " 5 "})) << output;
}

TEST_F(DamagedFiles, MessageNamesTheDefectOfAFrame) {
  using embree::cbvh::BlockHeader;
  Random random(8);
  SurfaceSettings settings;
  settings.rate = 16;
  RTCGeometry geometry = releasing(newSurface(device, cubeCage(), settings), RTC_COMPRESSION_CGRID, 0, 0);
  ASSERT_TRUE(saveGeometryFile(geometry, path.c_str()));
  rtcReleaseGeometry(geometry);
  const std::string bytes = bytesOf(path);
  const auto makeConstant = [](BlockHeader& block) {
    for (float(&column)[4] : block.columns)
      for (int k = 0; k < 3; k++) column[k] = 0;
  };
  const std::pair<const char*, std::function<void(BlockHeader&)>> cases[] = {
      {"center", [](BlockHeader& block) { block.center[1] = INFINITY; }},
      {"column", [](BlockHeader& block) { block.columns[2][3] = NAN; }},
      {"depend", makeConstant},
      {"depend",
       [&](BlockHeader& block) { // points on a line
         makeConstant(block);
         block.columns[0][3] = 0.5f;
       }}};
  for (const auto& [cause, damage] : cases) {
    SCOPED_TRACE(cause);
    FileBytes file(bytes);
    const auto& record = file.record(0);
    for (size_t i = 0; i < 6; i++) damage(*(BlockHeader*)&file.bytes[record.blocks + i * (record.blockBytes / 6)]);
    writeBytes(path, file.bytes);
    Scene scene(device);
    loadInto(scene);
    for (const RTCRayHit& hit : closestHits(scene, raysAt(random, 200), QueryForm::Single)) ASSERT_FALSE(isHit(hit));
    EXPECT_EQ(device.errors, 1u);
    expectError(path, {"geometry 0:", cause});
  }
}

// The index of findStoredTriangle is not larger for larger primitive numbers.
TEST_F(DamagedFiles, LargePrimitiveNumbersNeedNoMoreMemory) {
  const auto peakKiB = [] {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  constexpr uint32_t added = 0x08000000; // 4 bytes for each of these numbers are 512 MiB
  size_t altered = 0, found = 0;
  for (const Saveable& saveable : allSaveable()) {
    if (saveable.name.find("triangles") == std::string::npos && saveable.name.find("quads") == std::string::npos)
      continue;
    SCOPED_TRACE(saveable.name);
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, path.c_str()));
    FileBytes file(bytesOf(path));
    auto& record = file.record(0);
    const uint32_t numPrimitives = record.numPrimitives;
    const bool isTree = record.form == cvert::FILE_TREE;
    for (uint64_t i = isTree ? 0 : offsetof(cvert::FileEntry, child); i < record.treeBytes; i += isTree ? 8 : 32) {
      if (isTree && i % 128 >= 32) continue; // planes
      uint64_t child;
      std::memcpy(&child, &file.bytes[record.tree + i], sizeof(child));
      if ((child & cvert::FILE_CHILD_MASK) <= cvert::FILE_NODE) continue;
      char* const block = &file.bytes[record.blocks + (child & ~uint64_t(cvert::FILE_CHILD_MASK))];
      if (isMesh(cvert::FileChild(child & cvert::FILE_CHILD_MASK))) {
        cvert::MeshHeader& header = *(cvert::MeshHeader*)block;
        header.primID += header.info & cvert::meshHasQuads ? 2 * added : added; // numbers of triangles, two per quad
      } else ((cvert::VertHeader*)block)->primID += added;
      altered++;
    }
    record.numPrimitives += added;
    file.fitChecksums();
    writeBytes(path, file.bytes);
    RTCGeometry loaded = loadGeometryFile(device, path.c_str());
    ASSERT_NE(loaded, nullptr) << device.message;
    const long before = peakKiB();
    for (uint32_t primID = 0; primID < numPrimitives; primID += 101) {
      CbvhTriangle expected, actual;
      if (!findStoredTriangle(geometry, 0, primID, 0.3f, 0.3f, nullptr, &expected)) continue;
      ASSERT_TRUE(findStoredTriangle(loaded, 0, added + primID, 0.3f, 0.3f, nullptr, &actual)) << primID;
      ASSERT_EQ(std::memcmp(&actual, &expected, sizeof(actual)), 0) << primID;
      ASSERT_FALSE(findStoredTriangle(loaded, 0, primID, 0.3f, 0.3f, nullptr, &actual)) << primID;
      found++;
    }
    EXPECT_LT(peakKiB() - before, 100 * 1024);
    rtcReleaseGeometry(loaded);
    rtcReleaseGeometry(geometry);
  }
  EXPECT_GT(altered, 300u);
  EXPECT_GT(found, 1000u);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST_F(DamagedFiles, MutatedFilesAreRejectedOrTracedSafely) {
  size_t loaded = 0, refused = 0, hits = 0, withErrors = 0;
  const std::vector<Saveable> all = allSaveable();
  for (size_t kind = 0; kind < all.size(); kind++) {
    SCOPED_TRACE(all[kind].name);
    RTCGeometry geometry = all[kind].make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, path.c_str()));
    rtcReleaseGeometry(geometry);
    const std::string bytes = bytesOf(path);
    Random random(randomSeed(uint32_t(100 + kind)));
    for (size_t round = 0; round < randomRounds(40); round++) {
      writeBytes(path, mutated(random, bytes));
      const Trial trial = tryFile(device, path, folder / "copy", random);
      (trial.isLoaded ? loaded : refused)++;
      hits += trial.hits;
      withErrors += trial.isLoaded && trial.errors;
    }
  }
  // all outcomes occur
  EXPECT_GT(loaded, all.size());
  EXPECT_GT(refused, all.size());
  EXPECT_GT(hits, 1000u);
  EXPECT_GT(withErrors, 10u);
}

// --- disks -------------------------------------------------------------------------------------------

TEST_F(DamagedFiles, FullDiskLeavesTheOldFile) {
  const std::string old = "previous contents";
  for (size_t limit : {0ul, 100ul, 5000ul, sound.size() / 2, sound.size() - 100}) {
    SCOPED_TRACE(limit);
    writeBytes(path, sound);
    RTCGeometry geometry = loadGeometryFile(device, path.c_str());
    ASSERT_NE(geometry, nullptr);
    writeBytes(folder / "other", old);
    const int status = statusOfChild([&] {
      signal(SIGXFSZ, SIG_IGN);
      const rlimit full = {limit, limit};
      setrlimit(RLIMIT_FSIZE, &full);
      if (saveGeometryFile(geometry, (folder / "other").c_str())) return 1;
      if (device.takeError() != RTC_ERROR_INVALID_OPERATION) return 2;
      return containsInOrder(device.message, {folder / "other", std::strerror(EFBIG)}) ? 0 : 3;
    });
    EXPECT_EQ(status, 0);
    EXPECT_EQ(bytesOf(folder / "other"), old);
    EXPECT_EQ(folder.names().size(), 2u) << "a temporary file was left";
    rtcReleaseGeometry(geometry);
  }
}

TEST_F(DamagedFiles, KillWhileSavingLeavesTheOldFile) {
  RTCGeometry geometry = loadGeometryFile(device, path.c_str());
  ASSERT_NE(geometry, nullptr);
  const std::string old = "previous contents";
  // killed after each of these numbers of bytes
  size_t killed = 0;
  for (size_t limit : {100ul, 5000ul, sound.size() / 2, sound.size() - 100}) {
    writeBytes(folder / "other", old);
    const int status = statusOfChild([&] {
      bytesUntilKill = long(limit);
      saveGeometryFile(geometry, (folder / "other").c_str());
      return 1;
    });
    killed += WIFSIGNALED(status) != 0;
    EXPECT_EQ(bytesOf(folder / "other"), old);
  }
  EXPECT_EQ(killed, 4u);
  // remaining temporary files do not disturb, and are removed
  EXPECT_TRUE(saveGeometryFile(geometry, (folder / "other").c_str())) << device.message;
  EXPECT_EQ(folder.names().size(), 2u);
  EXPECT_EQ(bytesOf(folder / "other"), sound);
  rtcReleaseGeometry(geometry);
}

TEST_F(DamagedFiles, UnwritableFoldersAreReported) {
  RTCGeometry geometry = loadGeometryFile(device, path.c_str());
  ASSERT_NE(geometry, nullptr);
  for (const std::string& to : {folder / "none/file", folder / "surface.cbvh/file", std::string("/proc/surface.cbvh"),
                                std::string("/dev/null"), folder.path, std::string()}) {
    EXPECT_FALSE(saveGeometryFile(geometry, to.c_str()));
    expectError(to, {});
  }
  EXPECT_EQ(folder.names().size(), 1u);
  if (geteuid() != 0) { // permissions do not apply to root
    chmod(folder.path.c_str(), 0555);
    EXPECT_FALSE(saveGeometryFile(geometry, path.c_str()));
    expectError(path, {std::strerror(EACCES)});
    chmod(folder.path.c_str(), 0755);
  }
  EXPECT_EQ(bytesOf(path), sound);
  rtcReleaseGeometry(geometry);
}

TEST_F(DamagedFiles, ReadOnlyFileIsOpenedAndKeepsItsMode) {
  chmod(path.c_str(), 0440);
  // a second geometry writes to its own pages
  RTCGeometry geometry = loadGeometryFile(device, path.c_str()), second = loadGeometryFile(device, path.c_str());
  ASSERT_NE(geometry, nullptr) << device.message;
  ASSERT_NE(second, nullptr) << device.message;
  ASSERT_EQ(symlink("surface.cbvh", (folder / "link").c_str()), 0);
  EXPECT_TRUE(saveGeometryFile(second, (folder / "link").c_str())) << device.message;
  struct stat status;
  ASSERT_EQ(lstat((folder / "link").c_str(), &status), 0);
  EXPECT_TRUE(S_ISLNK(status.st_mode)) << "the link was replaced";
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0440u);
  EXPECT_EQ(bytesOf(path), sound);
  rtcReleaseGeometry(geometry);
  rtcReleaseGeometry(second);
}

// The first block is in one of the halves: damage of the other one is detected after some clusters.
TEST_F(DamagedFiles, ClusterReportContainsSumsBeforeTheDamage) {
  const StoredClusterFunction add = [](void* ptr, const CbvhCluster* cluster) {
    CbvhClusterStatistics& sums = *(CbvhClusterStatistics*)ptr;
    sums.numClusters++;
    sums.numTriangles += cluster->numTriangles;
    sums.bytes += cluster->bytes;
    return true;
  };
  size_t most = 0;
  for (int half : {0, 1}) {
    FileBytes file(sound);
    const uint64_t bytes = file.record(0).blockBytes / 2, begin = file.record(0).blocks + (half ? bytes : 0);
    std::fill_n(file.bytes.begin() + ptrdiff_t(begin), bytes, '\0');
    writeBytes(path, file.bytes);
    RTCGeometry geometry = loadGeometryFile(device, path.c_str());
    ASSERT_NE(geometry, nullptr) << device.message;
    CbvhClusterStatistics sums = CbvhClusterStatistics(), report = CbvhClusterStatistics();
    report.numClusters = report.numTriangles = report.bytes = report.numClustersByReason[3] = 12345;
    forEachStoredCluster(geometry, 0, CBVH_CLUSTER_FORMAT_FLOAT3, add, &sums, &report);
    EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
    EXPECT_EQ(report.numClusters, sums.numClusters);
    EXPECT_EQ(report.numTriangles, sums.numTriangles);
    EXPECT_EQ(report.bytes, sums.bytes);
    EXPECT_EQ(report.numClustersByReason[3], 0u);
    most = std::max(most, report.numClusters);
    rtcReleaseGeometry(geometry);
  }
  EXPECT_GT(most, 0u);
}

// A function that returns false needs no further blocks: the library neither reads nor checks them.
TEST_F(DamagedFiles, BlocksAfterTheEndOfAnEnumerationAreNotRead) {
  const StoredPartFunction countOne = [](void* calls, const CbvhPart*) {
    ++*(size_t*)calls;
    return false;
  };
  const StoredPartFunction countAll = [](void* calls, const CbvhPart*) {
    ++*(size_t*)calls;
    return true;
  };
  size_t most = 0;
  for (int half : {0, 1}) { // the order of blocks is unspecified: one half begins with a valid block
    FileBytes file(sound);
    const uint64_t bytes = file.record(0).blockBytes / 2, begin = file.record(0).blocks + (half ? bytes : 0);
    std::fill_n(file.bytes.begin() + ptrdiff_t(begin), bytes, '\0');
    writeBytes(path, file.bytes);
    size_t ended = 0, all = 0;
    RTCGeometry geometry = loadGeometryFile(device, path.c_str());
    ASSERT_NE(geometry, nullptr) << device.message;
    forEachStoredPart(geometry, 0, countOne, &ended);
    const RTCError error = device.takeError();
    EXPECT_LE(ended, 1u);
    EXPECT_EQ(error == RTC_ERROR_NONE, ended == 1) << device.message;
    forEachStoredPart(geometry, 0, countAll, &all);
    EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
    EXPECT_EQ(all > 0, ended == 1);
    most = std::max(most, all);
    rtcReleaseGeometry(geometry);
  }
  EXPECT_GT(most, 0u);
}

TEST_F(DamagedFiles, ReleasedWriterLeavesNoFile) {
  RTCGeometry geometry = loadGeometryFile(device, path.c_str());
  CbvhFileWriter writer = newFileWriter(device, path.c_str());
  EXPECT_TRUE(appendGeometry(writer, geometry));
  releaseWriter(writer);
  writer = newFileWriter(device, path.c_str());
  EXPECT_FALSE(commitWriter(writer)) << "without a geometry";
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  releaseWriter(writer);
  EXPECT_EQ(folder.names().size(), 1u);
  EXPECT_EQ(bytesOf(path), sound);
  rtcReleaseGeometry(geometry);
}

}} // namespace programs::test
