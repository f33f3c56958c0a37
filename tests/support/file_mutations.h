// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files with mutations at random positions or in chosen fields, and fitting checksums so that later checks are reached.
 * They must be rejected with a reason, or traced without harm. */

#include "kernels/cvert/file/format.h"
#include "support/query_forms.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <algorithm>
#include <string>
#include <vector>

namespace programs::test {

// CRC-32C bit by bit, as specified in docs/formats/file.md.
inline uint32_t crc32c(const char* data, size_t bytes) {
  uint32_t crc = 0xFFFFFFFFu;
  for (size_t i = 0; i < bytes; i++) {
    crc ^= (unsigned char)data[i];
    for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (crc & 1 ? 0x82F63B78u : 0);
  }
  return ~crc;
}

class FileBytes {
public:
  explicit FileBytes(std::string bytes) : bytes(std::move(bytes)) {}

  std::string bytes;

  cvert::FileHeader& header() { return *(cvert::FileHeader*)&bytes[0]; }
  cvert::FileGeometry& record(size_t i) {
    return *(cvert::FileGeometry*)&bytes[header().directory + i * sizeof(cvert::FileGeometry)];
  }
  size_t size() { return header().numGeometries; }

  // True if the directory can be read at its stated position.
  bool hasDirectory() {
    const uint64_t at = header().directory;
    return at % 8 == 0 && at <= bytes.size() && size() != 0 &&
           (bytes.size() - at) / sizeof(cvert::FileGeometry) >= size();
  }

  // Updates the checksums of trees, directory and header, not those of blocks.
  void fitChecksums() {
    using namespace cvert;
    if (hasDirectory()) {
      for (size_t i = 0; i < size(); i++) {
        FileGeometry& g = record(i);
        if (g.tree <= bytes.size() && g.treeBytes <= bytes.size() - g.tree)
          g.treeChecksum = crc32c(&bytes[g.tree], g.treeBytes);
      }
      header().directoryChecksum = crc32c(&bytes[header().directory], size() * sizeof(FileGeometry));
    }
    fitHeader();
  }
  void fitHeader() { header().checksum = crc32c(bytes.data(), offsetof(cvert::FileHeader, checksum)); }
};

inline uint64_t oddNumber(Random& random, uint64_t old) {
  switch (random.below(8)) {
  case 0: return 0;
  case 1: return ~uint64_t(0);
  case 2: return old + 1;
  case 3: return old - 1;
  case 4: return old ^ (uint64_t(1) << random.below(64));
  case 5: return old + 16 * random.below(64);
  case 6: return uint64_t(random.below(1u << 31)) << random.below(33);
  default: return old / 2;
  }
}

inline void alterWord(Random& random, std::string& bytes, size_t begin, size_t end, size_t width) {
  if (end < begin + width) return;
  const size_t at = begin + random.below(uint32_t((end - begin) / width)) * width;
  uint64_t word = 0;
  std::memcpy(&word, &bytes[at], width);
  word = oddNumber(random, word);
  std::memcpy(&bytes[at], &word, width);
}

inline std::string mutated(Random& random, const std::string& sound) {
  using namespace cvert;
  FileBytes file(sound);
  const uint32_t times = 1 + random.below(4);
  bool fits = false;
  for (uint32_t n = 0; n < times; n++) {
    if (!file.hasDirectory()) break;
    FileGeometry& g = file.record(0);
    const bool hasParts = g.tree <= file.bytes.size() && g.treeBytes <= file.bytes.size() - g.tree &&
                          g.blocks <= file.bytes.size() && g.blockBytes <= file.bytes.size() - g.blocks;
    switch (random.below(8)) {
    case 0:
      alterWord(random, file.bytes, 0, sizeof(FileHeader) - 4, 4);
      file.fitHeader();
      break;
    case 1:
      alterWord(random, file.bytes, file.header().directory, file.header().directory + sizeof(FileGeometry),
                random.chance(0.5) ? 4 : 8);
      fits = true;
      break;
    case 2:
      if (hasParts) alterWord(random, file.bytes, g.tree, g.tree + g.treeBytes, random.chance(0.5) ? 4 : 8);
      fits = true;
      break;
    case 3: // a length, together with the size of the file
      file.bytes.resize(random.chance(0.5) ? random.below(uint32_t(file.bytes.size()))
                                           : file.bytes.size() + random.below(10000));
      if (file.bytes.size() < sizeof(FileHeader)) return file.bytes;
      if (random.chance(0.5)) {
        file.header().fileBytes = file.bytes.size();
        file.fitHeader();
      }
      break;
    default: {
      if (!hasParts || g.blockBytes < 64) break;
      // a word of a block's header, any word of a block, or a block replaced by another one
      std::vector<uint64_t> blocks;
      const size_t stride = g.form == FILE_TREE ? 8 : 32;
      for (size_t i = 0; i + stride <= g.treeBytes; i += stride) {
        uint64_t child;
        std::memcpy(&child, &file.bytes[g.tree + i + (g.form == FILE_TREE ? 0 : 24)], sizeof(child));
        if (g.form == FILE_TREE && i % 128 >= 32) continue; // planes
        if ((child & 15) >= 2 && (child & 15) <= 5 && (child & ~uint64_t(15)) + 64 <= g.blockBytes)
          blocks.push_back(child & ~uint64_t(15));
      }
      if (blocks.empty()) break;
      const uint64_t block = g.blocks + blocks[random.below(uint32_t(blocks.size()))],
                     other = g.blocks + blocks[random.below(uint32_t(blocks.size()))];
      const uint64_t end = std::min<uint64_t>(g.blocks + g.blockBytes, block + 700);
      switch (random.below(4)) {
      case 0: alterWord(random, file.bytes, block, std::min<uint64_t>(block + 96, end), 4); break;
      case 1: file.bytes[block + random.below(uint32_t(end - block))] = char(random.below(256)); break;
      case 2:
        for (uint64_t i = block; i < end; i++)
          if (random.chance(0.05)) file.bytes[i] = char(random.below(256));
        break;
      default: {
        const std::string copy =
            file.bytes.substr(other, std::min(random.chance(0.5) ? 64u : random.below(700),
                                              unsigned(g.blocks + g.blockBytes - std::max(block, other))));
        file.bytes.replace(block, copy.size(), copy);
      }
      }
    }
    }
  }
  if (fits && random.chance(0.95)) file.fitChecksums();
  return file.bytes;
}

struct Trial {
  bool isLoaded = false, isVerified = false;
  size_t hits = 0, errors = 0;
};

// Opens and traces a file, whatever it contains. Primitive numbers of hits must belong to the geometry. copy:
// path to which the geometry is saved.
inline Trial tryFile(Device& device, const std::string& path, const std::string& copy, Random& random) {
  Trial trial;
  const auto failed = [&] {
    EXPECT_NE(device.takeError(), RTC_ERROR_NONE);
    EXPECT_FALSE(device.message.empty());
    return trial;
  };
  CbvhFile file = openFile(device, path.c_str());
  if (!file) return failed();
  RTCGeometry geometry = loadFromFile(device, file, 0);
  CbvhFileSurfaceInfo description;
  EXPECT_TRUE(infoOf(file, 0, &description));
  if (!geometry) {
    releaseFile(file);
    return failed();
  }
  trial.isLoaded = true;
  device.errors = 0;
  {
    Scene scene(device);
    // sometimes next to another geometry
    if (random.chance(0.3))
      if (RTCGeometry other = loadFromFile(device, file, 0)) attach(scene, other);
    const unsigned id = rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    std::vector<RTCRayHit> rays = raysAt(random, 120);
    for (RTCRayHit& r : rays) r.ray.time = description.numTimeSteps > 1 ? float(random.uniform(0, 1)) : 0;
    for (QueryForm form : {QueryForm::Single, QueryForm::Packet8, QueryForm::CoherentStream}) {
      for (const RTCRayHit& r : closestHits(scene, rays, form)) {
        if (!isHit(r)) continue;
        trial.hits++;
        EXPECT_LE(r.hit.geomID, id);
        EXPECT_LT(r.hit.primID, description.numPrimitives);
        CbvhTriangle triangle;
        if (form == QueryForm::Single)
          findStoredTriangle(geometry, r.ray.time, r.hit.primID, r.hit.u, r.hit.v, &r.hit.Ng_x, &triangle);
      }
      QueryRun(scene, form, true)(rays);
    }
    RTCPointQuery query = {0, 0, 0, 0.25f, 1};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, nullptr, nullptr);
    forEachStoredPart(geometry, description.startTime, [](void*, const CbvhPart*) { return true; }, nullptr);
  }
  trial.errors = device.errors;
  saveGeometryFile(geometry, copy.c_str());
  trial.isVerified = verifyFile(file);
  rtcReleaseGeometry(geometry);
  releaseFile(file);
  device.takeError();
  return trial;
}

} // namespace programs::test
