// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files that are written in several parts: resumeFileWriter. */

#include "kernels/cvert/file/file.h"
#include "kernels/cvert/file/writer.h"
#include "support/child_process.h"
#include "support/file_calls.h"
#include "support/file_mutations.h"
#include "support/message_parts.h"
#include "support/query_forms.h"
#include "support/surface_access.h"

#include <csignal>
#include <sys/resource.h>
#include <sys/wait.h>

namespace programs::test { namespace {

class ResumedFiles : public testing::Test {
protected:
  static constexpr unsigned long long key = 0x123456789abcdef0ull;

  CbvhFileWriter resume(unsigned long long of = key) { return resumeFileWriter(device, path.c_str(), of); }

  void append(CbvhFileWriter writer, size_t i) {
    RTCGeometry geometry = all[i].make(device);
    ASSERT_TRUE(appendGeometry(writer, geometry)) << device.message;
    rtcReleaseGeometry(geometry);
  }

  void expectRefused(const std::string& cause, unsigned long long of = key) {
    EXPECT_EQ(resume(of), nullptr);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(containsInOrder(device.message, {part, cause}));
  }

  /* The file contains the first n geometries, with equal hits to the bit. */
  void expectWhole(size_t n) {
    CbvhFile file = openFile(device, path.c_str());
    ASSERT_NE(file, nullptr) << device.message;
    EXPECT_TRUE(verifyFile(file)) << device.message;
    ASSERT_EQ(countOf(file), n);
    std::vector<RTCRayHit> rays = raysAt(random, 500);
    for (RTCRayHit& ray : rays) ray.ray.time = float(random.uniform(0, 1));
    for (unsigned i = 0; i < n; i++) {
      Scene from(device), made(device);
      RTCGeometry geometry = loadFromFile(device, file, i);
      ASSERT_NE(geometry, nullptr) << device.message;
      attach(from, geometry);
      attach(made, all[i].make(device));
      rtcCommitScene(from);
      rtcCommitScene(made);
      const std::vector<RTCRayHit> expected = closestHits(made, rays, QueryForm::Single),
                                   hits = closestHits(from, rays, QueryForm::Single);
      for (size_t k = 0; k < rays.size(); k++)
        ASSERT_TRUE(std::memcmp(&hits[k].ray.tfar, &expected[k].ray.tfar, sizeof(float)) == 0 &&
                    hits[k].hit.primID == expected[k].hit.primID &&
                    std::memcmp(&hits[k].hit.u, &expected[k].hit.u, 2 * sizeof(float)) == 0)
            << all[i].name << ", ray " << k;
    }
    releaseFile(file);
  }

  /* Writes only the first geometry. Returns the number of bytes. */
  size_t begin() {
    CbvhFileWriter writer = resume();
    append(writer, 0);
    releaseWriter(writer);
    return bytesOf(part).size();
  }

  /* The first geometry still exists, and the second completes the file. */
  void finish() {
    CbvhFileWriter writer = resume();
    ASSERT_NE(writer, nullptr) << device.message;
    EXPECT_EQ(countOf(writer), 1u);
    append(writer, 1);
    ASSERT_TRUE(commitWriter(writer)) << device.message;
    releaseWriter(writer);
    expectWhole(2);
  }

  Folder folder;
  Device device;
  Random random{7};
  const std::vector<Saveable> all = allSaveable();
  const std::string path = folder / "all.cbvh", part = path + ".part";
};

TEST_F(ResumedFiles, ReleasedWriterCanBeResumed) {
  for (size_t i = 0; i < all.size(); i++) { // each with a new writer
    CbvhFileWriter writer = resume();
    ASSERT_NE(writer, nullptr) << device.message;
    EXPECT_EQ(countOf(writer), i);
    append(writer, i);
    EXPECT_EQ(countOf(writer), i + 1);
    releaseWriter(writer);
    EXPECT_EQ(access(path.c_str(), F_OK), -1) << "the file exists before it is complete";
  }
  CbvhFileWriter writer = resume();
  ASSERT_TRUE(commitWriter(writer)) << device.message;
  releaseWriter(writer);
  EXPECT_EQ(folder.names(), std::vector<std::string>{"all.cbvh"});
  expectWhole(all.size());
}

TEST_F(ResumedFiles, UninterruptedFileMatchesPlainWriterExceptForKey) {
  auto write = [&](CbvhFileWriter writer) {
    ASSERT_NE(writer, nullptr) << device.message;
    append(writer, 0);
    ASSERT_TRUE(commitWriter(writer)) << device.message;
    releaseWriter(writer);
  };
  write(resume(0));
  const std::string resumed = bytesOf(path);
  write(newFileWriter(device, path.c_str()));
  EXPECT_EQ(resumed == bytesOf(path), true);
}

TEST_F(ResumedFiles, FileSystemsWithoutFsyncAreSupported) {
  for (int error : {EINVAL, EROFS, EIO}) {
    SCOPED_TRACE(strerror(error));
    fsyncError = error;
    CbvhFileWriter writer = resume();
    append(writer, 0);
    const bool isWritten = commitWriter(writer);
    fsyncError = 0;
    EXPECT_EQ(isWritten, error != EIO);
    EXPECT_EQ(access(path.c_str(), F_OK) == 0, error != EIO);
    EXPECT_EQ(device.takeError(), error == EIO ? RTC_ERROR_INVALID_OPERATION : RTC_ERROR_NONE) << device.message;
    RTCGeometry another = all[1].make(device);
    EXPECT_FALSE(appendGeometry(writer, another)) << "after a commit or a failed write";
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
    rtcReleaseGeometry(another);
    releaseWriter(writer);
    unlink(path.c_str());
  }
}

TEST_F(ResumedFiles, KillLosesOnlyDataAfterTheLastFlush) {
  begin();
  RTCGeometry second = all[1].make(device);
  size_t killed = 0;
  for (long more : {0l, 100l, 4000l, 5000l}) { // written before the process is killed
    const int status = statusOfChild([&] {
      bytesUntilKill = more;
      appendGeometry(resume(), second);
      return 1;
    });
    killed += WIFSIGNALED(status) != 0;
  }
  rtcReleaseGeometry(second);
  EXPECT_EQ(killed, 4u);
  finish();
}

TEST_F(ResumedFiles, FullDiskKeepsSavedData) {
  const size_t saved = begin();
  RTCGeometry second = all[1].make(device);
  const int status = statusOfChild([&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit full = {saved + 5000, saved + 5000};
    setrlimit(RLIMIT_FSIZE, &full);
    CbvhFileWriter writer = resume();
    if (appendGeometry(writer, second)) return 1;
    if (device.takeError() != RTC_ERROR_INVALID_OPERATION) return 2;
    if (commitWriter(writer)) return 3;
    releaseWriter(writer);
    return 0;
  });
  EXPECT_EQ(status, 0);
  rtcReleaseGeometry(second);
  finish();
}

TEST_F(ResumedFiles, ForeignFilesAreRejectedAndUnchanged) {
  CbvhFileWriter writer = resume();
  append(writer, 0);
  expectRefused("writer");
  releaseWriter(writer);
  const std::string sound = bytesOf(part);
  expectRefused("key", key + 1);
  expectRefused("key", key ^ (1ull << 63));
  EXPECT_EQ(bytesOf(part), sound);
  auto expectAltered = [&](size_t at, const std::string& cause) {
    std::string bytes = sound;
    bytes[at] ^= 1;
    writeBytes(part, bytes);
    expectRefused(cause);
    EXPECT_EQ(bytesOf(part), bytes);
  };
  expectAltered(0, "surfaces");
  expectAltered(12, "version");
  expectAltered(24, "damaged");
  expectAltered(sound.size() - 1, "damaged"); // in the directory
  for (const std::string& bytes : {sound.substr(0, sound.size() - 1), sound.substr(0, 64)}) {
    writeBytes(part, bytes);
    expectRefused("truncated");
  }
  writeBytes(part, "mesh");
  expectRefused("surfaces");
  /* a part without saved geometries is started again */
  for (const std::string& bytes : {std::string(), std::string(4096, '\0'), std::string(64, '\0') + "x"}) {
    writeBytes(part, bytes);
    writer = resume();
    ASSERT_NE(writer, nullptr) << device.message;
    EXPECT_EQ(countOf(writer), 0u);
    releaseWriter(writer);
    EXPECT_TRUE(folder.names().empty()) << "an empty part must not leave files";
  }
}

/* A file is resumed if and only if it could be opened once it is committed. Changed fields have fitting checksums. */
TEST_F(ResumedFiles, ReadersAndResumedWritersAcceptTheSameFiles) {
  CbvhFileWriter writer = resume();
  append(writer, 0);
  append(writer, 1);
  releaseWriter(writer);
  const std::string sound = bytesOf(part);
  size_t accepted = 0, refused = 0;
  const auto expectSame = [&](const char* what, const std::function<void(FileBytes&)>& change) {
    SCOPED_TRACE(what);
    FileBytes file(sound);
    change(file);
    if (file.hasDirectory()) file.fitChecksums();
    file.fitHeader();
    writeBytes(path, file.bytes);
    writeBytes(part, file.bytes);
    const auto errorOf = [](const std::function<void()>& open) {
      try {
        open();
      } catch (const cvert::Error& error) { return std::string(error.what()); }
      return std::string();
    };
    const std::string reader = errorOf([&] { cvert::File opened(path); });
    const std::string writer = errorOf([&] { cvert::FileWriter resumed(path, key); });
    EXPECT_EQ(reader.empty(), writer.empty()) << reader << writer;
    (reader.empty() ? accepted : refused)++;
    if (!reader.empty() && !writer.empty()) { // the same reason, with the other path
      EXPECT_TRUE(containsInOrder(writer, {part + reader.substr(path.size()), "remove"}));
    }
    unlink(path.c_str());
    unlink(part.c_str());
  };
  for (uint32_t version = 0; version <= cvert::movingMeshFormatVersion + 1; version++) {
    expectSame("cVERT version", [&](FileBytes& file) { file.header().vertVersion = version; });
    expectSame("version of frames", [&](FileBytes& file) { file.header().framedVersion = version; });
  }
  expectSame("no geometries", [](FileBytes& file) { file.header().numGeometries = 0; });
  expectSame("size of records", [](FileBytes& file) { file.header().recordBytes = 16; });
  expectSame("position", [](FileBytes& file) { file.header().directory = file.bytes.size(); });
  expectSame("misaligned", [](FileBytes& file) {
    file.header().numGeometries--;
    file.header().directory += 8;
  });
  expectSame("form", [](FileBytes& file) { file.record(1).form = 9; });
  expectSame("source", [](FileBytes& file) { file.record(1).source = 9; });
  expectSame("compression", [](FileBytes& file) { file.record(0).compression = 1; });
  expectSame("tree", [](FileBytes& file) { file.record(0).treeBytes -= 8; });
  expectSame("position of a tree", [](FileBytes& file) { file.record(1).tree += 16; });
  expectSame("outside", [](FileBytes& file) { file.record(1).blocks = uint64_t(1) << 40; });
  expectSame("blocks", [](FileBytes& file) { file.record(1).numBlocks = ~uint64_t(0); });
  expectSame("steps", [](FileBytes& file) { file.record(0).numTimeSteps = 1u << 20; });
  expectSame("surface number", [](FileBytes& file) { file.record(1).surface = file.record(0).surface; });
  expectSame("bounds", [](FileBytes& file) { file.record(0).upper[1] = std::numeric_limits<float>::quiet_NaN(); });
  expectSame("reserved", [](FileBytes& file) { file.record(1).reserved[1] = 1; });
  expectSame("overlap", [](FileBytes& file) { file.record(1).blocks = file.record(0).blocks; });
  expectSame("primitives", [](FileBytes& file) { file.record(1).numPrimitives++; });
  Random random(77);
  for (int i = 0; i < 2000; i++)
    expectSame("any word", [&](FileBytes& file) {
      const size_t i = random.below(uint32_t(file.size()));
      const size_t at = file.header().directory + i * sizeof(cvert::FileGeometry);
      alterWord(random, file.bytes, at, at + sizeof(cvert::FileGeometry), random.chance(0.5) ? 4 : 8);
    });
  EXPECT_GT(accepted, 100u);
  EXPECT_GT(refused, 100u);
}

TEST_F(ResumedFiles, NullIsRejected) {
  EXPECT_EQ(resumeFileWriter(device, nullptr, key), nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(countOf(CbvhFileWriter(nullptr)), 0u);
}

}} // namespace programs::test
