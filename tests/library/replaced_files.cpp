// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Saves over existing files: links, devices, files of killed writers, and concurrent writers. */

#include "support/child_process.h"
#include "support/file_calls.h"
#include "support/message_parts.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>

namespace programs::test { namespace {

class ReplacedFiles : public testing::Test {
protected:
  ReplacedFiles() : geometry(newOne()) {}
  ~ReplacedFiles() { rtcReleaseGeometry(geometry); }

  RTCGeometry newOne() {
    SurfaceSettings settings;
    settings.rate = 4;
    return releasing(newSurface(device, quadCage(), settings), RTC_COMPRESSION_CVERT);
  }

  bool save(const std::string& to) { return saveGeometryFile(geometry, to.c_str()); }

  void expectLoadable(const std::string& from) {
    CbvhFile file = openFile(device, from.c_str());
    ASSERT_NE(file, nullptr) << device.message;
    EXPECT_TRUE(verifyFile(file)) << device.message;
    releaseFile(file);
  }

  void expectError(const std::vector<std::string>& parts) {
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(containsInOrder(device.message, parts));
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all = folder.names();
    std::sort(all.begin(), all.end());
    return all;
  }

  static struct stat linkStatus(const std::string& of) {
    struct stat status;
    EXPECT_EQ(lstat(of.c_str(), &status), 0) << of;
    return status;
  }

  Folder folder;
  Device device;
  RTCGeometry geometry;
  const std::string path = folder / "a.cbvh";
};

TEST_F(ReplacedFiles, LinkStaysAndItsTargetIsReplaced) {
  writeBytes(folder / "target", "old");
  ASSERT_EQ(chmod((folder / "target").c_str(), 0640), 0);
  ASSERT_EQ(symlink("target", (folder / "link").c_str()), 0);
  ASSERT_EQ(symlink("link", path.c_str()), 0);
  ASSERT_TRUE(save(path)) << device.message;
  EXPECT_TRUE(S_ISLNK(linkStatus(path).st_mode) && S_ISLNK(linkStatus(folder / "link").st_mode));
  EXPECT_EQ(linkStatus(folder / "target").st_mode & 07777, 0640u);
  expectLoadable(folder / "target");
  EXPECT_EQ(names(), (std::vector<std::string>{"a.cbvh", "link", "target"}));
}

TEST_F(ReplacedFiles, DanglingLinkStaysAndItsTargetIsCreated) {
  ASSERT_EQ(symlink("target", path.c_str()), 0);
  ASSERT_TRUE(save(path)) << device.message;
  EXPECT_TRUE(S_ISLNK(linkStatus(path).st_mode));
  EXPECT_TRUE(S_ISREG(linkStatus(folder / "target").st_mode));
  expectLoadable(path);
  ASSERT_EQ(symlink("round", (folder / "round").c_str()), 0);
  EXPECT_FALSE(save(folder / "round"));
  expectError({folder / "round", std::strerror(ELOOP)});
}

TEST_F(ReplacedFiles, NonRegularFilesAreRejectedAndStay) {
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_FALSE(save(path));
  expectError({path, "regular"});
  EXPECT_TRUE(S_ISFIFO(linkStatus(path).st_mode));
  ASSERT_EQ(symlink("/dev/null", (folder / "link").c_str()), 0);
  EXPECT_FALSE(save(folder / "link"));
  expectError({folder / "link", "regular"});
  EXPECT_TRUE(S_ISLNK(linkStatus(folder / "link").st_mode) && S_ISCHR(linkStatus("/dev/null").st_mode));
  EXPECT_FALSE(save(folder.path));
  expectError({folder.path, std::strerror(EISDIR)});
  /* like /dev/stdout redirected to a file that other processes also write */
  writeBytes(folder / "log", "begin\n");
  const int log = open((folder / "log").c_str(), O_WRONLY | O_APPEND);
  EXPECT_FALSE(save("/dev/fd/" + std::to_string(log)));
  expectError({"/dev/fd/" + std::to_string(log), "regular"});
  close(log);
  EXPECT_EQ(bytesOf(folder / "log"), "begin\n");
  EXPECT_EQ(names(), (std::vector<std::string>{"a.cbvh", "link", "log"}));
}

TEST_F(ReplacedFiles, NonRegularFilesDoNotBlock) {
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  alarm(20); // opening a FIFO without a writer would block forever
  EXPECT_EQ(loadGeometryFile(device, path.c_str()), nullptr);
  expectError({path, "pipe", "regular"});
  EXPECT_EQ(openFile(device, path.c_str()), nullptr);
  expectError({path, "pipe", "regular"});
  ASSERT_EQ(rename(path.c_str(), (path + ".part").c_str()), 0);
  EXPECT_EQ(resumeFileWriter(device, path.c_str(), 1), nullptr);
  expectError({path + ".part", "regular"});
  EXPECT_EQ(loadGeometryFile(device, "/dev/zero"), nullptr);
  expectError({"/dev/zero", "device", "regular"});
  alarm(0);
}

TEST_F(ReplacedFiles, OnlyFilesOfKilledWritersAreRemoved) {
  const auto beginInChild = [&](const std::string& to) {
    EXPECT_TRUE(WIFSIGNALED(statusOfChild([&] {
      newFileWriter(device, to.c_str());
      return raise(SIGKILL);
    })));
  };
  beginInChild(path);
  const std::vector<std::string> killed = names();
  ASSERT_EQ(killed.size(), 1u) << "the writer has no temporary file";
  beginInChild(folder / "b.cbvh");
  writeBytes(folder / "a.cbvh.part-1-0", "another program's");
  writeBytes(folder / "a.cbvh.cbvh-part-readme", "another program's");
  CbvhFileWriter alive = newFileWriter(device, path.c_str());
  ASSERT_NE(alive, nullptr);
  EXPECT_NE(access((folder / killed[0]).c_str(), F_OK), 0) << "the killed writer's file still exists";
  EXPECT_EQ(names().size(), 4u) << "one for the other path, two of other programs, one that is being written";
  ASSERT_TRUE(save(path)) << device.message;
  EXPECT_EQ(names().size(), 5u);
  ASSERT_TRUE(appendGeometry(alive, geometry) && commitWriter(alive)) << device.message;
  releaseWriter(alive);
  EXPECT_EQ(names().size(), 4u);
  expectLoadable(path);
}

// Unlike temporary files, these names do not contain ".cbvh-part-".
TEST_F(ReplacedFiles, FilesWithSimilarNamesStay) {
  const auto take = [&](int process, int count) {
    writeBytes(path + ".part-" + std::to_string(process) + "-" + std::to_string(count), "");
  };
  for (int process = 1; process < 40000; process += process < 100 ? 1 : 397)
    for (int count = 0; count < 4; count++) take(process, count);
  for (int count = 0; count < 1000; count++) take(getpid(), count);
  const size_t before = names().size();
  EXPECT_TRUE(save(path)) << device.message;
  EXPECT_EQ(names().size(), before + 1);
}

TEST_F(ReplacedFiles, NamesUpToTheFileSystemsLimitAreSupported) {
  const auto nameOf = [](size_t bytes) { return std::string(bytes, 'n'); };
  for (size_t bytes : {228u, 229u, 245u, 250u, 251u, 255u}) {
    SCOPED_TRACE(bytes);
    const std::string to = folder / nameOf(bytes);
    ASSERT_TRUE(save(to)) << device.message;
    CbvhFileWriter writer = resumeFileWriter(device, to.c_str(), 1);
    ASSERT_NE(writer, nullptr) << device.message;
    ASSERT_TRUE(appendGeometry(writer, geometry)) << device.message;
    releaseWriter(writer);
    EXPECT_EQ(names().size(), 2u);
    writer = resumeFileWriter(device, to.c_str(), 1);
    ASSERT_NE(writer, nullptr) << device.message;
    EXPECT_EQ(countOf(writer), 1u) << "the writer starts again";
    ASSERT_TRUE(commitWriter(writer)) << device.message;
    releaseWriter(writer);
    expectLoadable(to);
    EXPECT_EQ(names(), std::vector<std::string>{nameOf(bytes)});
    std::remove(to.c_str());
  }
  const std::string tooLong = folder / nameOf(256);
  EXPECT_EQ(newFileWriter(device, tooLong.c_str()), nullptr) << "the error must be reported at creation";
  expectError({tooLong, std::strerror(ENAMETOOLONG)});
  /* two long names that differ in their last byte must not share a file */
  CbvhFileWriter writers[2];
  for (int i = 0; i < 2; i++) {
    writers[i] = resumeFileWriter(device, (folder / (nameOf(254) + std::to_string(i))).c_str(), 1);
    EXPECT_NE(writers[i], nullptr) << device.message;
  }
  for (CbvhFileWriter writer : writers) releaseWriter(writer);
  EXPECT_TRUE(names().empty());
}

TEST_F(ReplacedFiles, FileSizeLimitIsAnErrorAndLeavesNoFile) {
  ASSERT_TRUE(save(path));
  const size_t whole = bytesOf(path).size();
  std::remove(path.c_str());
  for (size_t limit : {size_t(0), size_t(100), size_t(4096), whole - 100}) {
    SCOPED_TRACE(limit);
    const int status = statusOfChild([&] {
      signal(SIGXFSZ, SIG_DFL);
      const rlimit none = {0, 0}, full = {limit, limit};
      setrlimit(RLIMIT_CORE, &none);
      setrlimit(RLIMIT_FSIZE, &full);
      if (save(path)) return 1;
      if (device.takeError() != RTC_ERROR_INVALID_OPERATION) return 2;
      return containsInOrder(device.message, {path, std::strerror(EFBIG)}) ? 0 : 3;
    });
    EXPECT_EQ(status, 0) << "values below 128 are signals";
    EXPECT_TRUE(names().empty());
  }
}

// A process that holds the lock of a partial file must not lose it before the file has its final name.
TEST_F(ReplacedFiles, ConcurrentResumingProcessesCommitCompleteFiles) {
  constexpr int processes = 3, rounds = 40;
  std::vector<pid_t> children;
  for (int p = 0; p < processes; p++) {
    const pid_t child = fork();
    if (child != 0) {
      children.push_back(child);
      continue;
    }
    renameDelay = 2000;
    int commits = 0, spoiled = 0;
    for (int tries = 0; commits < rounds && tries < 100000; tries++) {
      CbvhFileWriter writer = resumeFileWriter(device, path.c_str(), 7);
      if (!writer) {
        usleep(200);
        continue;
      } // another process holds it
      commits++;
      const bool isNew = countOf(writer) == 0;
      const bool isComplete = isNew && appendGeometry(writer, geometry) && commitWriter(writer);
      spoiled += !isComplete;
      releaseWriter(writer);
    }
    _exit(commits < rounds || renameCalls < rounds ? 101 : std::min(spoiled, 100));
  }
  size_t opened = 0, damaged = 0, ended = 0;
  while (ended < children.size()) {
    if (access(path.c_str(), F_OK) == 0) {
      CbvhFile file = openFile(device, path.c_str());
      opened++;
      damaged += !file || !verifyFile(file);
      if (file) releaseFile(file);
    }
    int status = 0;
    const pid_t child = waitpid(-1, &status, WNOHANG);
    if (child <= 0) continue;
    ended++;
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0) << "a commit failed, or found an incomplete part";
  }
  EXPECT_EQ(damaged, 0u) << "of " << opened << ": " << device.message;
  EXPECT_GT(opened, 100u);
  EXPECT_EQ(names(), std::vector<std::string>{"a.cbvh"});
}

}} // namespace programs::test
