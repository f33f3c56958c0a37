// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "writer.h"
#include "../decoder/decoded_block.h"
#include "directory.h"
#include "record.h"
#include <algorithm>
#include <cerrno>
#include <cstring>

namespace cvert {
uint64_t FileSurface::append(FileChild type, const void* data, uint32_t bytes, uint32_t surfaceOffset) {
  const uint64_t begin = blockBytes;
  blocks.push_back({data, bytes, surfaceOffset});
  blockBytes = (begin + bytes + blockAlignment - 1) & ~uint64_t(blockAlignment - 1);
  vertVersion = std::max(vertVersion, leastVertVersion(type));
  return begin | type;
}

const void* FileSurface::keep(const void* block, size_t bytes) {
  kept.emplace_back(new char[bytes + vertReadPadding]());
  std::memcpy(kept.back().get(), block, bytes);
  return kept.back().get();
}

void FileSurface::appendToList(const void* data, uint32_t bytes) {
  if (record.form != FILE_LIST && record.form != FILE_MOVING)
    throw Error(ErrorCode::INVALID_ARGUMENT, "the surface's record has form " + std::to_string(record.form) +
                                                 ": expected FILE_LIST (1) or FILE_MOVING (2)");
  const VertHeader* const block = (const VertHeader*)data;
  if (const Reason reason = validateVertBlock(record, block, bytes))
    throw Error(reason.code, "the block cannot be saved: " + reason.message());
  const bool moves = isMoving(block->info);
  if (blocks.empty())
    for (int k = 0; k < 3; k++) {
      record.lower[k] = infinity;
      record.upper[k] = -infinity;
    }
  FileEntry entry = FileEntry();
  bool hasFiniteVertex = false;
  for (uint32_t step = 0; step < (moves ? motionOf(block).numSteps : 1); step++) {
    float lower[3], upper[3];
    if (!DecodedBlock(block, step).bounds(lower, upper)) continue;
    hasFiniteVertex = true;
    for (int k = 0; k < 3; k++) {
      record.lower[k] = minimum(lower[k], record.lower[k]);
      record.upper[k] = maximum(upper[k], record.upper[k]);
      if (!moves) {
        entry.lower[k] = lower[k];
        entry.upper[k] = upper[k];
      }
    }
  }
  if (!hasFiniteVertex) throw Error(ErrorCode::INVALID_ARGUMENT, "the block cannot be saved: it has no finite vertex");
  entry.child = append(moves ? FILE_MOVING_VERT : FILE_VERT, block, bytes, offsetof(VertHeader, surface));
  tree.insert(tree.end(), (const char*)&entry, (const char*)(&entry + 1));
}

void FileWriter::open(const std::string& suffix) {
  if (path.empty()) throw Error(ErrorCode::INVALID_ARGUMENT, "path is empty");
  std::string name = path;
  try {
    const OutputPath output(path);
    if (output.kind == OutputPath::STREAM)
      throw Error(ErrorCode::INVALID_ARGUMENT,
                  path + ": is a device, a pipe or an open descriptor: expected a regular file");
    name = output.path + suffix;
    file.reset(suffix.empty() ? new UnfinishedFile(output) : new UnfinishedFile(output, suffix));
  } catch (const std::system_error& error) {
    const bool isLocked = error.code().value() == EWOULDBLOCK;
    if (isLocked) throw Error(ErrorCode::INVALID_ARGUMENT, name + ": is being written by another writer");
    throw Error(ErrorCode::INVALID_ARGUMENT, name + ": cannot be written: " + error.code().message());
  }
}

FileWriter::FileWriter(const std::string& path) : path(path), isResumable(false) {
  open("");
  begin();
}

FileWriter::FileWriter(const std::string& path, uint64_t key) : path(path), isResumable(true), key(key) {
  open(".part");
  resume();
}

FileWriter::~FileWriter() {
  if (!file || !isResumable) return;
  try {
    if (!failed && !directory.empty() && writtenBytes != checkpointedBytes) writeDirectory();
  } catch (...) {} // the file still contains what the header on the disk refers to
  file->setPersistent(checkpointedBytes != 0);
}

void FileWriter::begin() {
  file->copyPermissions();
  const FileHeader blank = FileHeader();
  write(&blank, sizeof(blank));
  padTo(filePage);
}

void FileWriter::resume() {
  const int descriptor = file->descriptor();
  auto reject = [&](const std::string& reason) {
    throw Error(ErrorCode::INVALID_ARGUMENT, file->path() + ": " + reason);
  };
  struct stat status;
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) reject("is not a regular file");
  FileHeader header = FileHeader();
  const FileHeader blank = FileHeader();
  auto read = [&](void* data, size_t bytes, uint64_t offset) {
    const ssize_t n = readAllAt(descriptor, data, bytes, offset);
    if (n < 0) reject(std::string("cannot be read: ") + std::strerror(errno));
    return size_t(n) == bytes;
  };
  const bool isShort = !read(&header, sizeof(header), 0);
  const bool isBlank = memcmp(&header, &blank, sizeof(blank)) == 0;
  if (isShort || isBlank) {
    // a blank or missing header: there is no checkpoint; a short file with other bytes is of another kind
    if (!isBlank) reject("is not a file of compressed surfaces");
    if (::ftruncate(descriptor, 0) != 0) reject(std::string("cannot be written: ") + std::strerror(errno));
    return begin();
  }
  const bool isOfThisKind = memcmp(header.magic, fileMagic, sizeof(fileMagic)) == 0;
  const std::string hint = isOfThisKind ? "; remove it to start again" : "";
  if (const Reason reason = validateHeader(header)) reject(reason.message() + hint);
  const uint64_t fileBytes = uint64_t(status.st_size);
  if (header.fileBytes > fileBytes)
    reject(Reason::damaged("is truncated: it has % bytes, expected %", fileBytes, header.fileBytes).message() + hint);
  if (const Reason reason = validateDirectoryPlace(header)) reject(reason.message() + hint);
  if (header.key[0] != uint32_t(key) || header.key[1] != uint32_t(key >> 32))
    reject("was started with another key" + hint);
  vertVersion = header.vertVersion;
  directory.resize(size_t(header.numGeometries));
  const size_t bytes = directory.size() * sizeof(FileGeometry);
  if (!read(directory.data(), bytes, header.directory) ||
      header.directoryChecksum != fileChecksum(directory.data(), bytes))
    reject("is damaged: the checksum of its directory differs" + hint);
  try {
    requireDirectory(file->path(), directory.data(), directory.size(), header.fileBytes);
  } catch (const Error& error) { throw Error(ErrorCode::INVALID_ARGUMENT, error.what() + hint); }
  for (const FileGeometry& record : directory) numbers.insert(record.surface & ~(firstFileNumber | movingSurface));
  writtenBytes = checkpointedBytes = header.fileBytes;
  if (::ftruncate(descriptor, off_t(writtenBytes)) != 0 || ::lseek(descriptor, off_t(writtenBytes), SEEK_SET) < 0)
    reject(std::string("cannot be written: ") + std::strerror(errno));
}

void FileWriter::fail(const std::string& what) {
  failed = true;
  throw Error(ErrorCode::INVALID_OPERATION, path + ": " + what);
}

void FileWriter::failToWrite(int error) { fail(std::string("cannot be written: ") + std::strerror(error)); }

void FileWriter::write(const void* data, size_t bytes) {
  const int error = writeAll(file->descriptor(), data, bytes);
  if (error) failToWrite(error);
  writtenBytes += bytes;
}

void FileWriter::padTo(uint64_t alignment) {
  static const char zeros[filePage] = {};
  if (writtenBytes % alignment) write(zeros, size_t(alignment - writtenBytes % alignment));
}

uint32_t FileWriter::chooseSurfaceNumber(const FileGeometry& record) {
  // a hash, so that equal surfaces produce equal files, and numbers of different files rarely collide
  const uint32_t count = firstFileNumber - 1; // excludes ~0u as number of a moving surface: it is reserved
  uint32_t number = fileChecksum(&record, sizeof(record)) % count;
  while (!numbers.insert(number).second) number = (number + 1) % count;
  return number | firstFileNumber | (record.form == FILE_MOVING ? movingSurface : 0);
}

void FileWriter::requireOpen() const {
  if (!file) throw Error(ErrorCode::INVALID_OPERATION, path + ": was already committed");
  if (failed) throw Error(ErrorCode::INVALID_OPERATION, path + ": could not be written earlier");
}

void FileWriter::add(FileSurface& surface) {
  requireOpen();
  if (isResumable && writtenBytes - checkpointedBytes >= checkpointInterval) writeDirectory();
  padTo(filePage);
  FileGeometry& record = surface.record;
  record.tree = record.blocks = 0;
  record.surface = record.blocksChecksum = 0;
  record.numBlocks = surface.blocks.size();
  record.treeBytes = surface.tree.size();
  record.blockBytes = surface.blockBytes;
  record.treeChecksum = fileChecksum(surface.tree.data(), surface.tree.size());
  record.surface = chooseSurfaceNumber(record);
  if (const Reason reason = validateRecord(record))
    throw Error(ErrorCode::INVALID_OPERATION, "the geometry cannot be saved: " + reason.message());
  record.tree = writtenBytes;
  write(surface.tree.data(), surface.tree.size());
  padTo(filePage);
  record.blocks = writtenBytes;
  writeBlocks(surface);
  const uint64_t end = writtenBytes;
  padTo(filePage);
  if (writtenBytes - end < fileReadPadding) {
    const char zeros[fileReadPadding] = {};
    write(zeros, sizeof(zeros));
    padTo(filePage);
  }
  directory.push_back(record);
  vertVersion = std::max(vertVersion, surface.vertVersion);
  // starts writing to disk, so that the next checkpoint need not wait
  if (isResumable) (void)!::sync_file_range(file->descriptor(), off_t(checkpointedBytes), 0, SYNC_FILE_RANGE_WRITE);
}

void FileWriter::writeBlocks(FileSurface& surface) {
  std::vector<char> buffer;
  auto flush = [&] {
    surface.record.blocksChecksum = fileChecksum(buffer.data(), buffer.size(), surface.record.blocksChecksum);
    write(buffer.data(), buffer.size());
    buffer.clear();
  };
  for (const FileSurface::Block& block : surface.blocks) {
    const size_t begin = buffer.size();
    buffer.resize(begin + ((block.bytes + blockAlignment - 1) & ~size_t(blockAlignment - 1)));
    memcpy(buffer.data() + begin, block.data, block.bytes);
    memcpy(buffer.data() + begin + block.surfaceOffset, &surface.record.surface, sizeof(surface.record.surface));
    if (buffer.size() >= size_t(1) << 20) flush(); // writes of about 1 MiB
  }
  flush();
}

void FileWriter::writeDirectory() {
  FileHeader header = FileHeader();
  memcpy(header.magic, fileMagic, sizeof(header.magic));
  header.byteOrder = fileByteOrder;
  header.version = fileVersion;
  header.vertVersion = vertVersion;
  header.framedVersion = fileFramedVersion;
  header.numGeometries = uint32_t(directory.size());
  header.recordBytes = sizeof(FileGeometry);
  header.directory = writtenBytes;
  const size_t bytes = directory.size() * sizeof(FileGeometry);
  header.directoryChecksum = fileChecksum(directory.data(), bytes);
  write(directory.data(), bytes);
  header.fileBytes = writtenBytes;
  header.key[0] = uint32_t(key);
  header.key[1] = uint32_t(key >> 32);
  header.checksum = fileChecksum(&header, offsetof(FileHeader, checksum));
  // the header of a resumable file must only refer to data on the disk
  int error = isResumable ? flushToDisk(file->descriptor()) : 0;
  if (!error) error = writeAllAt(file->descriptor(), &header, sizeof(header), 0);
  if (!error) error = flushToDisk(file->descriptor());
  if (error) failToWrite(error);
  checkpointedBytes = writtenBytes;
}

void FileWriter::commit() {
  requireOpen();
  if (directory.empty()) throw Error(ErrorCode::INVALID_OPERATION, path + ": no geometry was added");
  if (writtenBytes != checkpointedBytes) writeDirectory();
  try {
    file->commit();
  } catch (const std::system_error& error) {
    throw Error(ErrorCode::INVALID_OPERATION, path + ": cannot be written: " + error.code().message());
  }
  file.reset();
}
} // namespace cvert
