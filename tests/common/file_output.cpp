// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/file_output.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "kernels/cvert/file/unfinished_file.h"
#include "pictures/image_output.h"
#include "surface/height_map.h"
#include "surface/mesh.h"
#include "support/child_process.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sys/resource.h>
#include <sys/stat.h>
#include <system_error>
#include <thread>

namespace programs::test { namespace {

namespace fs = std::filesystem;

std::string textOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class FileOutput : public testing::Test {
protected:
  FileOutput() {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  ~FileOutput() { fs::remove_all(folder); }

  std::string at(const std::string& name) const { return (folder / name).string(); }
  size_t files() const { return size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator())); }

  static void expectError(const std::function<void()>& write, const std::vector<std::string>& parts) {
    try {
      write();
      ADD_FAILURE() << "expected an error: " << testing::PrintToString(parts);
    } catch (const Error& e) { EXPECT_TRUE(containsInOrder(e.what(), parts)); }
  }

  const fs::path folder = fs::temp_directory_path() / ("cbvh_file_output_" + std::to_string(getpid()));
};

/* --- destinations --------------------------------------------------------------------- */

TEST_F(FileOutput, FileIsReplacedAndKeepsItsPermissions) {
  writeTextFile(at("a"), "old");
  ASSERT_EQ(chmod(at("a").c_str(), 0604), 0);
  std::ifstream before(at("a"));
  writeTextFile(at("a"), "new");
  EXPECT_EQ(textOf(at("a")), "new");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(before), {}), "old") << "the file was overwritten in place";
  struct stat status;
  ASSERT_EQ(stat(at("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0604u);
  EXPECT_EQ(files(), 1u);
}

TEST_F(FileOutput, LinksStayAndTheirTargetIsWritten) {
  fs::create_directory(folder / "store");
  fs::create_symlink("store/a", folder / "link");
  fs::create_symlink(at("link"), folder / "another");
  for (const char* text : {"first", "second"}) // first without a target, then with it
  {
    writeTextFile(at("another"), text);
    EXPECT_TRUE(fs::is_symlink(folder / "another") && fs::is_symlink(folder / "link"));
    EXPECT_EQ(textOf(at("store/a")), text);
  }
  EXPECT_EQ(files(), 3u);
}

TEST_F(FileOutput, DevicesAndPipesAreWrittenInPlace) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", folder / "link");
  const std::string text(1 << 18, 'x'); // more than the capacity of a pipe
  for (const char* name : {"pipe", "link"}) {
    std::string found;
    std::thread reader([&] { found = textOf(at(name)); });
    writeTextFile(at(name), text);
    reader.join();
    EXPECT_TRUE(found == text) << found.size() << " bytes";
    EXPECT_EQ(fs::symlink_status(folder / "pipe").type(), fs::file_type::fifo);
  }
  fs::create_symlink("/dev/null", folder / "null");
  writeTextFile(at("null"), text);
  writeTextFile("/dev/null", text);
  EXPECT_TRUE(fs::is_symlink(folder / "null"));
  EXPECT_EQ(fs::status("/dev/null").type(), fs::file_type::character);
  fs::create_symlink("/dev/full", folder / "full");
  expectError([&] { writeTextFile(at("full"), text); }, {at("full"), std::strerror(ENOSPC)});
  EXPECT_EQ(files(), 4u);
}

/* The system reads and writes at most 0x7ffff000 bytes per call, and fewer if a signal arrives. */
TEST(FileTransfers, ContinueAfterShortCallsAndSignals) {
  const std::string text = "0123456789";
  unsigned calls = 0;
  // every second call is interrupted, the others transfer up to 3 bytes
  const auto transfer = [&](char* to, const char* from, size_t bytes) -> ssize_t {
    if (calls++ % 2 == 0) {
      errno = EINTR;
      return -1;
    }
    const size_t n = std::min<size_t>(bytes, 3);
    std::copy_n(from, n, to);
    return ssize_t(n);
  };
  std::string written(text.size(), ' '), read(text.size(), ' ');
  EXPECT_EQ(cvert::putAll(text.data(), text.size(),
                          [&](const char* from, size_t bytes, size_t done) {
                            return transfer(written.data() + done, from, bytes);
                          }),
            0);
  EXPECT_EQ(written, text);
  const auto get = [&](char* to, size_t bytes, size_t done) {
    return transfer(to, text.data() + done, std::min(bytes, text.size() - done));
  };
  EXPECT_EQ(cvert::getAll(read.data(), read.size(), get), ssize_t(text.size()));
  EXPECT_EQ(read, text);
  read.resize(text.size() + 5);
  EXPECT_EQ(cvert::getAll(read.data(), read.size(), get), ssize_t(text.size())) << "the file ends";
  EXPECT_EQ(cvert::getAll(read.data(), 1,
                          [](char*, size_t, size_t) {
                            errno = EIO;
                            return ssize_t(-1);
                          }),
            -1);
}

/* For writers that do not distinguish devices and pipes from files, such as caches. */
TEST_F(FileOutput, UnfinishedFileReplacesNoDeviceAndNoPipe) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/null", folder / "link");
  for (const std::string& path : {std::string("/dev/null"), std::string("/dev/stdout"), at("link"), at("pipe")}) {
    EXPECT_THROW(cvert::UnfinishedFile{cvert::OutputPath(path)}, std::system_error) << path;
    EXPECT_THROW((cvert::UnfinishedFile{cvert::OutputPath(path), ".part"}), std::system_error) << path;
  }
  EXPECT_EQ(files(), 2u);
}

/* Like >(command) of a shell, and /dev/stdout redirected to a file. */
TEST_F(FileOutput, DescriptorsOfTheProcessAreWrittenInPlace) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  writeTextFile("/dev/fd/" + std::to_string(ends[1]), "through a pipe");
  close(ends[1]);
  char text[64] = "";
  EXPECT_EQ(read(ends[0], text, sizeof(text)), 14);
  EXPECT_STREQ(text, "through a pipe");
  close(ends[0]);

  const int log = open(at("log").c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_EQ(write(log, "one ", 4), 4);
  writeTextFile("/proc/self/fd/" + std::to_string(log), "two ");
  ASSERT_EQ(write(log, "three", 5), 5);
  close(log);
  EXPECT_EQ(textOf(at("log")), "one two three");
  EXPECT_EQ(files(), 1u);
}

TEST_F(FileOutput, FileOfStandardOutputIsWrittenInPlace) {
  const int status = statusOfChild([&] {
    dup2(open(at("log").c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
    std::printf("one ");
    writeTextFile(at("log"), "two ");
    std::printf("three ");
    std::fflush(stdout);
    writeTextFile("/dev/stdout", "four");
    return 0;
  });
  EXPECT_EQ(status, 0);
  EXPECT_EQ(textOf(at("log")), "one two three four");
  EXPECT_EQ(files(), 1u);
}

TEST_F(FileOutput, ImagesAreWrittenIntoPipes) {
  Image image(ImageSize{40, 30});
  writePng(at("picture.png"), image);
  ASSERT_EQ(mkfifo(at("pipe.png").c_str(), 0600), 0);
  std::string found;
  std::thread reader([&] { found = textOf(at("pipe.png")); });
  writePng(at("pipe.png"), image);
  reader.join();
  EXPECT_TRUE(!found.empty() && found == textOf(at("picture.png")));
}

TEST_F(FileOutput, FailedWritesAreReportedAndLeaveNoFile) {
  expectError([&] { writeTextFile(at("missing/a"), "x"); }, {at("missing/a"), std::strerror(ENOENT)});
  expectError([&] { writeTextFile(at(""), "x"); }, {folder.string(), std::strerror(EISDIR)});
  const std::string tooLong = at(std::string(256, 'n'));
  expectError([&] { writeTextFile(tooLong, "x"); }, {tooLong, std::strerror(ENAMETOOLONG)});
  writeTextFile(at(std::string(255, 'n')), "x");
  EXPECT_EQ(files(), 1u);
}

/* --- full disks and limits --------------------------------------------------------------- */

/* Each writer with each limit of the file size: an error, and an empty folder. */
TEST_F(FileOutput, FileSizeLimitsAreErrorsOfEachWriter) {
  const ImageSize size{64, 48};
  const Crop whole{0, 0, size.width, size.height};
  const size_t pixels = size_t(size.width) * size_t(size.height);
  Image image(size);
  HeightMap map(64, 64);
  for (size_t i = 0; i < pixels; i++) {
    const float gray = float(i * 7919 % 997) / 997.0f; // hardly compressible
    image.set(i, Vec3f{gray, 1.0f - gray, gray * gray});
  }
  const std::vector<Vec3f> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<std::array<unsigned, 4>> quads(500, std::array<unsigned, 4>{0, 1, 2, 3});
  const std::pair<const char*, std::function<void(const std::string&)>> writers[] = {
      {"a.txt", [&](const std::string& path) { writeTextFile(path, std::string(10000, 'x')); }},
      {"a.png", [&](const std::string& path) { writePng(path, image); }},
      {"a.exr",
       [&](const std::string& path) {
         const std::vector<SurfaceHit> hits(pixels);
         writeExr(path, size, whole, std::vector<Vec3f>(pixels), std::vector<Ray>(pixels), hits);
       }},
      {"map.exr", [&](const std::string& path) { map.write(path); }},
      {"a.obj", [&](const std::string& path) { writeObj(path, vertices, quads); }}};
  for (const auto& [name, write] : writers) {
    const std::string path = at(name);
    write(path);
    const size_t bytes = fs::file_size(path);
    fs::remove(path);
    ASSERT_GT(bytes, 1000u) << name;
    for (size_t limit : {size_t(0), bytes / 2, bytes - 1}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(limit) + " of " + std::to_string(bytes) + " bytes");
      const auto handler = std::signal(SIGXFSZ, SIG_IGN); // like runProgram
      rlimit before;
      ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
      const rlimit most = {limit, before.rlim_max};
      setrlimit(RLIMIT_FSIZE, &most);
      std::string error = "none";
      try {
        write(path);
      } catch (const Error& e) { error = e.what(); }
      setrlimit(RLIMIT_FSIZE, &before);
      std::signal(SIGXFSZ, handler);
      EXPECT_EQ(error.find(path + ": "), 0u) << error;
      EXPECT_NE(error.find(std::strerror(EFBIG)), std::string::npos) << error;
      EXPECT_EQ(files(), 0u) << name;
    }
  }
}

/* --- inputs ----------------------------------------------------------------------------- */

TEST_F(FileOutput, InputsAreNotReplaced) {
  writeTextFile(at("skin.png"), "heights");
  writeTextFile(at("other.png"), "");
  fs::create_symlink("skin.png", folder / "link.png");
  fs::create_hard_link(folder / "skin.png", folder / "same.png");
  recordInputFile(at("skin.png"));
  recordInputFile(at("missing.png"));
  recordInputFile("/dev/null");
  for (const char* name : {"skin.png", "link.png", "same.png", "./skin.png"}) {
    const std::vector<std::string> parts = {at(name), name == std::string("skin.png") ? "" : at("skin.png"), "input"};
    expectError([&] { requireNoInputFile(at(name)); }, parts);
    expectError([&] { writeTextFile(at(name), "x"); }, parts);
    expectError([&] { writePng(at(name), Image(ImageSize{4, 4})); }, parts);
  }
  EXPECT_EQ(textOf(at("skin.png")), "heights");
  writeTextFile(at("other.png"), "x");
  writeTextFile(at("missing.png"), "x");
  writeTextFile("/dev/null", "x");
  /* a new file with the inode of a deleted input is not an input */
  fs::rename(folder / "skin.png", folder / "moved.png");
  writeTextFile(at("moved.png"), "x");
  EXPECT_EQ(textOf(at("moved.png")), "x");
}

}} // namespace programs::test
