// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "directory.h"
#include "record.h"
#include <algorithm>
#include <cstring>
#include <unordered_set>
#include <vector>

namespace cvert {
namespace {
Reason checkVersion(uint32_t found, uint32_t oldest, uint32_t newest, const char* tooOld, const char* tooNew) {
  if (found < oldest) return Reason::unsupported(tooOld, found, oldest);
  if (found > newest) return Reason::unsupported(tooNew, found, newest);
  return Reason();
}

/*! Readers find the geometry of a block by its address. */
void requireDisjointBlocks(const std::string& path, const FileGeometry* records, size_t count) {
  std::vector<size_t> order;
  for (size_t i = 0; i < count; i++)
    if (records[i].blockBytes) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return records[a].blocks < records[b].blocks; });
  for (size_t k = 1; k < order.size(); k++) {
    const FileGeometry& before = records[order[k - 1]];
    if (records[order[k]].blocks - before.blocks < before.blockBytes)
      failGeometry(path, order[k], "", Reason::damaged("its blocks overlap the blocks of geometry %", order[k - 1]));
  }
}
} // namespace

Reason validateHeader(const FileHeader& h) {
  if (memcmp(h.magic, fileMagic, sizeof(fileMagic)) != 0)
    return Reason::damaged("is not a file of compressed surfaces");
  if (h.byteOrder != fileByteOrder) return Reason::damaged("has another byte order: expected little-endian");
  if (const Reason reason = checkVersion(h.version, fileVersion, fileVersion,
                                         "has an older version of these files, %: this library reads % and later",
                                         "has a newer version of these files, %: this library reads versions up to %"))
    return reason;
  if (h.checksum != fileChecksum(&h, offsetof(FileHeader, checksum)))
    return Reason::damaged("is damaged: the checksum of its header differs");
  if (const Reason reason =
          checkVersion(h.vertVersion, oldestVertVersion, movingMeshFormatVersion,
                       "has blocks of an older version of cVERT, %: this library reads % and later",
                       "has blocks of a newer version of cVERT, %: this library reads versions up to %"))
    return reason;
  return checkVersion(h.framedVersion, fileFramedVersion, fileFramedVersion,
                      "has blocks with frames of an older version, %: this library reads % and later",
                      "has blocks with frames of a newer version, %: this library reads versions up to %");
}

Reason validateDirectoryPlace(const FileHeader& h) {
  if (h.recordBytes != sizeof(FileGeometry) || h.numGeometries == 0 || h.directory > h.fileBytes ||
      h.directory % 16 != 0 || (h.fileBytes - h.directory) / sizeof(FileGeometry) < h.numGeometries)
    return Reason::damaged("is damaged: its directory of % geometries at % is empty, misaligned, outside of the file "
                           "or of another record size",
                           h.numGeometries, h.directory);
  return Reason();
}

void requireDirectory(const std::string& path, const FileGeometry* records, size_t count, uint64_t bytes) {
  std::unordered_set<uint32_t> numbers;
  for (size_t i = 0; i < count; i++) {
    const FileGeometry& g = records[i];
    auto isPart = [&](uint64_t begin, uint64_t size, uint64_t after) {
      return begin % filePage == 0 && begin <= bytes && size <= bytes - begin && after <= bytes - begin - size;
    };
    auto failDamaged = [&](const char* why) { failGeometry(path, i, "", Reason::damaged(why)); };
    if (!isPart(g.tree, g.treeBytes, 0)) failDamaged("its tree is outside of the file");
    if (!isPart(g.blocks, g.blockBytes, fileReadPadding)) failDamaged("its blocks are outside of the file");
    if (const Reason reason = validateRecord(g)) failGeometry(path, i, "", reason);
    if (!numbers.insert(g.surface).second) failDamaged("its surface number is also another geometry's");
  }
  requireDisjointBlocks(path, records, count);
}

void failGeometry(const std::string& path, size_t i, const std::string& where, const Reason& reason) {
  const bool isUnsupported = reason.code == ErrorCode::UNSUPPORTED;
  throw Error(isUnsupported ? ErrorCode::UNSUPPORTED : ErrorCode::DAMAGED,
              path + (isUnsupported ? ": geometry " : ": is damaged: geometry ") + std::to_string(i) + ": " + where +
                  reason.message());
}
} // namespace cvert
