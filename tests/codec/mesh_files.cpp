// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files with moving mesh blocks are read as written; older readers reject them by version; blocks that do not move as
 * their geometry does are rejected. */

#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/file/file.h"
#include "kernels/cvert/file/tree_reader.h"
#include "kernels/cvert/file/writer.h"
#include "support/message_parts.h"
#include "support/moving_mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <unistd.h>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t numSteps = 3;

// A path of this process. The file is removed at the end.
struct TemporaryFile {
  const std::string path = testing::TempDir() + "mesh_files." + std::to_string(::getpid()) + ".cbvh";
  ~TemporaryFile() { ::unlink(path.c_str()); }
};

// The blocks of a moving sheet, as a list.
struct Saved {
  std::vector<EncodedBlock> blocks;
  FileSurface surface;
  ErrorCode readerError = ErrorCode::NONE;

  Saved() {
    Random random(3181);
    auto encoder = std::make_unique<MeshMotionEncoder>();
    MeshStatistics statistics;
    const MovingMesh mesh = sheet(random, 30, numSteps, -1000, bent);
    blocks = encode(*encoder, mesh, 16, statistics);
    FileGeometry& record = surface.record;
    record.form = FILE_MOVING;
    record.source = FILE_TRIANGLES;
    record.compression = FILE_COMPRESSION_VERT;
    record.numPrimitives = uint32_t(mesh.triangles.size());
    record.numTimeSteps = numSteps;
    record.begin = 0.25f;
    record.end = 0.75f;
    for (int k = 0; k < 3; k++) {
      record.lower[k] = -100;
      record.upper[k] = 100;
    }
    for (const EncodedBlock& block : blocks) add(block, FILE_MOVING_MESH);
  }

  void add(const EncodedBlock& block, FileChild type) {
    FileEntry entry = FileEntry();
    entry.child = surface.append(type, block.words.data(), uint32_t(block.size()), offsetof(MeshHeader, surface));
    surface.tree.insert(surface.tree.end(), (const char*)&entry, (const char*)(&entry + 1));
  }

  // Writes and verifies a file. Returns the message of the reader's error, or "".
  std::string write(const std::string& path) {
    FileWriter writer(path);
    writer.add(surface);
    writer.commit();
    try {
      File(path).verify();
    } catch (const Error& error) {
      readerError = error.code;
      return error.what();
    }
    return "";
  }
};

TEST(MeshFiles, BlocksAreReadAsTheyWereWritten) {
  const TemporaryFile temporary;
  Saved saved;
  ASSERT_GT(saved.blocks.size(), 4u);
  ASSERT_EQ(saved.write(temporary.path), "");
  const File file(temporary.path);
  size_t n = 0;
  const Reason reason = forEachBlock(file.geometry(0), file.tree(0), [&](FileChild type, uint64_t offset) {
    ASSERT_EQ(type, FILE_MOVING_MESH);
    const EncodedBlock& expected = saved.blocks[n++];
    MeshHeader header;
    std::memcpy(&header, expected.words.data(), sizeof(header));
    header.surface = file.geometry(0).surface;
    EXPECT_EQ(std::memcmp(file.blocks(0) + offset, &header, sizeof(header)), 0);
    EXPECT_EQ(std::memcmp(file.blocks(0) + offset + sizeof(header), (const char*)expected.words.data() + sizeof(header),
                          expected.size() - sizeof(header)),
              0);
  });
  EXPECT_EQ(reason.message(), "");
  EXPECT_EQ(n, saved.blocks.size());
  EXPECT_EQ(motionOfMesh((const MeshHeader*)file.blocks(0)).numSteps, numSteps);
}

#if defined(FILE_TO_OBJ)
// The example of the codec writes the triangles of mesh blocks at their first step.
TEST(MeshFiles, AreWrittenAsObj) {
  const TemporaryFile temporary;
  Saved saved;
  ASSERT_EQ(saved.write(temporary.path), "");
  FILE* const pipe = ::popen((std::string(FILE_TO_OBJ " ") + temporary.path).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<unsigned, 3>> triangles;
  char line[256];
  while (std::fgets(line, sizeof(line), pipe)) {
    std::array<float, 3> p;
    std::array<unsigned, 3> t;
    if (std::sscanf(line, "v %f %f %f", &p[0], &p[1], &p[2]) == 3) vertices.push_back(p);
    if (std::sscanf(line, "f %u %u %u", &t[0], &t[1], &t[2]) == 3) triangles.push_back(t);
  }
  EXPECT_EQ(::pclose(pipe), 0);

  size_t n = 0;
  unsigned first = 1;
  for (const EncodedBlock& block : saved.blocks) {
    const auto decoded = std::make_unique<DecodedMesh>((const MeshHeader*)block.words.data());
    for (unsigned i = 0; i < decoded->numTriangles; i++, n++) {
      ASSERT_LT(n, triangles.size());
      for (int c = 0; c < 3; c++) {
        const unsigned corner = decoded->triangles[i][c];
        ASSERT_EQ(triangles[n][c], first + corner);
        ASSERT_LE(triangles[n][c], vertices.size());
        for (int k = 0; k < 3; k++) EXPECT_EQ(vertices[first + corner - 1][k], decoded->vertices[corner][k]);
      }
    }
    first += decoded->numVertices;
  }
  EXPECT_EQ(n, triangles.size());
}
#endif

// Readers before version 7 compare vertVersion, the word at 16, with 6.
TEST(MeshFiles, OlderReadersRejectTheFileByVersion) {
  const TemporaryFile temporary;
  Saved saved;
  ASSERT_EQ(saved.write(temporary.path), "");
  std::ifstream file(temporary.path, std::ios::binary);
  FileHeader header;
  file.read((char*)&header, sizeof(header));
  EXPECT_EQ(header.vertVersion, movingMeshFormatVersion);
}

TEST(MeshFiles, BlocksThatMoveOtherwiseAreRejected) {
  const TemporaryFile temporary;
  for (int change = 0; change < 4; change++) {
    Saved saved;
    FileGeometry& record = saved.surface.record;
    if (change == 0) record.numTimeSteps = numSteps + 1;
    if (change == 1) record.end = 1;
    if (change == 2) record.numPrimitives = 100;
    EncodedBlock other = saved.blocks[0];
    if (change == 3) { // the first step alone
      MeshHeader& header = *(MeshHeader*)other.words.data();
      other.words.resize(header.motion / 4);
      MeshHeader& still = *(MeshHeader*)other.words.data();
      still.bytes = still.motion;
      still.motion = 0;
      still.counts &= ~(1u << 15); // version 6
      ASSERT_EQ(validateMesh(other.words.data(), other.size()).message(), "");
      saved.add(other, FILE_MOVING_MESH);
    }
    const std::vector<std::string> causes[] = {
        {" " + std::to_string(numSteps) + " time steps", " " + std::to_string(numSteps + 1)},
        {"time range"},
        {"primitive", " 100"},
        {"no", "steps"}};
    std::vector<std::string> parts = {temporary.path, "geometry 0:", "block"};
    parts.insert(parts.end(), causes[change].begin(), causes[change].end());
    EXPECT_TRUE(containsInOrder(saved.write(temporary.path), parts)) << change;
    EXPECT_EQ(saved.readerError, ErrorCode::DAMAGED) << change;
  }
}

// NaN compares neither below nor above: such bounds are not empty.
TEST(MeshFiles, BoundsThatAreNotNumbersAreRejected) {
  const TemporaryFile temporary;
  for (int k = 0; k < 3; k++)
    for (bool isUpper : {false, true}) {
      Saved saved;
      FileGeometry& record = saved.surface.record;
      (isUpper ? record.upper : record.lower)[k] = NAN;
      try {
        saved.write(temporary.path);
        ADD_FAILURE() << "axis " << k;
      } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::INVALID_OPERATION);
        EXPECT_NE(std::string(error.what()).find("bounds"), std::string::npos) << error.what();
      }
    }
}

// The type of a child must fit the form of the tree.
TEST(MeshFiles, StillTreesHaveNoMovingBlocks) {
  const TemporaryFile temporary;
  Saved saved;
  FileGeometry& record = saved.surface.record;
  record.form = FILE_LIST;
  record.numTimeSteps = 1;
  EXPECT_TRUE(containsInOrder(saved.write(temporary.path), {temporary.path, "geometry 0:", "type 6"}));
  EXPECT_EQ(saved.readerError, ErrorCode::DAMAGED);
}

}} // namespace programs::test
