// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/file_output.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/progress.h"
#include "kernels/cvert/file/unfinished_file.h"

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <sys/mman.h>
#include <vector>

namespace programs {

namespace fs = std::filesystem;
using cvert::OutputPath;
using cvert::UnfinishedFile;

namespace {

std::mutex createdFoldersMutex;
std::vector<fs::path> createdFolders; // by prepareOutputFolder, a folder before its parents

class Descriptor {
public:
  explicit Descriptor(int number) : number(number) {
    if (number < 0) cvert::throwErrno(errno);
  }
  ~Descriptor() { close(number); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  const int number;
};

/* Buffers all bytes until the commit, because image writers seek. */
struct Stream {
  explicit Stream(const OutputPath& output)
    : target(output.descriptor >= 0 ? fcntl(output.descriptor, F_DUPFD_CLOEXEC, 0)
                                    : open(output.path.c_str(), O_WRONLY | O_TRUNC | O_NOCTTY | O_CLOEXEC)),
      memory(memfd_create("output", MFD_CLOEXEC)),
      name("/proc/self/fd/" + std::to_string(memory.number)) {}

  void copyToTarget() const {
    std::fflush(stdout); // stdout may be the target
    std::vector<char> piece(1 << 20);
    for (off_t at = 0;;) {
      const ssize_t bytes = cvert::readAllAt(memory.number, piece.data(), piece.size(), uint64_t(at));
      if (bytes == 0) return;
      const int error = bytes < 0 ? errno : cvert::writeAll(target.number, piece.data(), size_t(bytes));
      if (error) cvert::throwErrno(error);
      at += bytes;
    }
  }

  const Descriptor target, memory;
  const std::string name;
};

Error writeError(const std::string& path, const std::string& why) {
  return Error(path + ": cannot be written: " + why);
}

} // namespace

struct PendingFile::Destination {
  explicit Destination(const OutputPath& output) {
    if (output.kind == OutputPath::STREAM) stream = std::make_unique<Stream>(output);
    else {
      file = std::make_unique<UnfinishedFile>(output);
      file->copyPermissions();
    }
  }

  int descriptor() const { return file ? file->descriptor() : stream->memory.number; }

  std::unique_ptr<UnfinishedFile> file; // exactly one of the two is set
  std::unique_ptr<Stream> stream;
  int error = 0;
};

PendingFile::PendingFile(const std::string& path) : path(path) {
  requireNoInputFile(path);
  try {
    destination = std::make_unique<Destination>(OutputPath(path));
  } catch (const std::system_error& e) { throw writeError(path, e.code().message()); }
  if (destination->file) setUnfinishedFile(temporary());
}

PendingFile::~PendingFile() {
  destination.reset();
  setUnfinishedFile("");
}

const std::string& PendingFile::temporary() const {
  return destination->file ? destination->file->path() : destination->stream->name;
}

bool PendingFile::write(const void* data, size_t bytes, uint64_t offset) noexcept {
  const int error = cvert::writeAllAt(destination->descriptor(), data, bytes, offset);
  if (!destination->error) destination->error = error;
  return error == 0;
}

std::string PendingFile::error() const { return destination->error ? std::strerror(destination->error) : ""; }

void PendingFile::commit() {
  try {
    if (destination->error) cvert::throwErrno(destination->error);
    if (destination->file) destination->file->commit();
    else destination->stream->copyToTarget();
  } catch (const std::system_error& e) { throw writeError(path, e.code().message()); }
}

void requireWritable(const std::string& path) {
  try {
    const OutputPath output(path);
    if (output.kind != OutputPath::STREAM) const UnfinishedFile probe(output);
  } catch (const std::system_error& e) { throw writeError(path, e.code().message()); }
}

void writeTextFile(const std::string& path, const std::string& text) {
  PendingFile file(path);
  file.write(text.data(), text.size(), 0);
  file.commit();
}

void writeStandardOutput(const std::string& text) {
  const bool isWritten = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) || !isWritten)
    throw Error(std::string("standard output cannot be written: ") + std::strerror(errno));
}

void prepareOutputFolder(const std::string& path) {
  std::error_code code;
  std::vector<fs::path> missing; // the deepest first
  for (fs::path folder = fs::absolute(path, code); !folder.empty() && !fs::exists(folder, code);
       folder = folder.parent_path())
    missing.push_back(folder);
  fs::create_directories(path, code);
  {
    const std::lock_guard<std::mutex> lock(createdFoldersMutex);
    createdFolders.insert(createdFolders.begin(), missing.begin(), missing.end());
  }
  if (code || !fs::is_directory(path, code))
    throw Error(path + ": cannot create this output folder: " + (code ? code.message() : "it is a file"));
  /* Some file systems report wrong permissions, so create a file. */
  try {
    const UnfinishedFile probe(OutputPath((fs::path(path) / "cbvh-probe").string()));
  } catch (const std::system_error& e) {
    throw Error(path + ": cannot create files in this folder: " + e.code().message());
  }
}

void removeEmptyOutputFolders() {
  const std::lock_guard<std::mutex> lock(createdFoldersMutex);
  std::error_code ignored;
  for (const fs::path& folder : createdFolders)
    if (fs::is_directory(folder, ignored) && fs::is_empty(folder, ignored)) fs::remove(folder, ignored);
  createdFolders.clear();
}

} // namespace programs
