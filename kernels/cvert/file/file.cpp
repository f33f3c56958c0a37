// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "file.h"
#include "directory.h"
#include "tree_reader.h"
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cvert {
namespace {
const char* kindOfFile(mode_t mode) {
  return S_ISDIR(mode) ? "a folder" : S_ISFIFO(mode) ? "a pipe" : S_ISSOCK(mode) ? "a socket" : "a device";
}
} // namespace

// O_NONBLOCK: otherwise, opening a FIFO would wait for its writer
File::File(const std::string& path)
  : path(path),
    file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
  if (file < 0) throw Error(ErrorCode::INVALID_ARGUMENT, path + ": cannot be opened: " + std::strerror(errno));
  try {
    map();
    if (const Reason reason = validate()) throw Error(reason.code, path + ": " + reason.message());
  } catch (...) {
    unmap();
    throw;
  }
}

File::~File() { unmap(); }

void File::map() {
  auto fail = [&](const std::string& why) { throw Error(ErrorCode::INVALID_ARGUMENT, path + ": " + why); };
  struct stat status;
  if (::fstat(file, &status) != 0) fail(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) fail(std::string("is ") + kindOfFile(status.st_mode) + ": expected a regular file");
  bytes = uint64_t(status.st_size);
  if (bytes < sizeof(FileHeader))
    fail("is not a file of compressed surfaces: it has only " + std::to_string(bytes) + " bytes");
  void* const mapped = ::mmap(nullptr, size_t(bytes), PROT_READ, MAP_PRIVATE, file, 0);
  if (mapped == MAP_FAILED) fail(std::string("cannot be mapped: ") + std::strerror(errno));
  data = (const char*)mapped;
}

void File::unmap() {
  if (data) ::munmap((void*)data, size_t(bytes));
  ::close(file);
}

Reason File::validate() const {
  const FileHeader& h = *header();
  if (const Reason reason = validateHeader(h)) return reason;
  if (h.fileBytes > bytes) return Reason::damaged("is truncated: it has % bytes, expected %", bytes, h.fileBytes);
  if (h.fileBytes < bytes)
    return Reason::damaged("has data after its end: it has % bytes, expected %", bytes, h.fileBytes);
  if (const Reason reason = validateDirectoryPlace(h)) return reason;
  if (h.directoryChecksum != fileChecksum(data + h.directory, h.numGeometries * sizeof(FileGeometry)))
    return Reason::damaged("is damaged: the checksum of its directory differs");
  requireDirectory(path, &geometry(0), size(), bytes);
  return Reason();
}

void File::fail(size_t i, const std::string& where, const Reason& reason) const {
  failGeometry(path, i, where, reason);
}

void File::failDamaged(size_t i, const std::string& why) const { fail(i, why, Reason::damaged("")); }
void File::failUnsupported(size_t i, const std::string& why) const { fail(i, why, Reason::unsupported("")); }

void File::verifyGeometry(size_t i, const BlockCheck& other) const {
  const FileGeometry& record = geometry(i);
  if (record.blocksChecksum != fileChecksum(blocks(i), size_t(record.blockBytes)))
    failDamaged(i, "the checksum of its blocks differs");
  const Reason reason = forEachBlock(record, tree(i), [&](FileChild type, uint64_t offset) {
    if (type == FILE_FRAMED && !other) return;
    const char* const block = blocks(i) + offset;
    const size_t bytes = size_t(record.blockBytes - offset);
    Reason reason = validateBlock(blockTypeOf(type, record.form == FILE_MOVING), record, block, bytes, other);
    if (!reason && type != FILE_FRAMED && ((const VertHeader*)block)->surface != record.surface)
      reason = Reason::damaged("its surface number differs from its geometry's");
    if (reason) fail(i, "the block at " + std::to_string(offset) + ": ", reason);
  });
  if (reason) fail(i, "", reason);
}
} // namespace cvert
