// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target of the codec: arbitrary bytes as a file, with corrected checksums so that later checks run. Errors name
// the file. The blocks of its geometries do not overlap. Valid blocks decode, even if the file does not verify. A
// file that verifies has as many blocks as its records state.

#include "block_seeds.h"
#include "kernels/cvert/decoder/decoded_block.h"
#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/file/file.h"
#include "kernels/cvert/file/tree_reader.h"
#include "kernels/cvert/file/writer.h"

#include <algorithm>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

namespace programs::test {
namespace {

// A file in memory with a path.
class MemoryFile {
public:
  explicit MemoryFile(const std::string& bytes)
    : file(memfd_create("fuzz", 0)),
      path("/proc/self/fd/" + std::to_string(file)) {
    REQUIRE(file >= 0 && write(file, bytes.data(), bytes.size()) == ssize_t(bytes.size()));
  }
  MemoryFile(const MemoryFile&) = delete;
  ~MemoryFile() { close(file); }

private:
  const int file;

public:
  const std::string path;
};

// --- checksums -----------------------------------------------------------------------------

bool isInside(uint64_t begin, uint64_t bytes, const std::string& file) {
  return begin <= file.size() && bytes <= file.size() - begin;
}

template<typename T>
T at(const std::string& file, uint64_t offset) {
  T value;
  std::memcpy(&value, &file[offset], sizeof(value));
  return value;
}

void seal(std::string& file) {
  if (file.size() < sizeof(FileHeader)) return;
  FileHeader header = at<FileHeader>(file, 0);
  if (isInside(header.directory, uint64_t(header.numGeometries) * sizeof(FileGeometry), file)) {
    for (uint32_t i = 0; i < header.numGeometries; i++) {
      const uint64_t begin = header.directory + i * sizeof(FileGeometry);
      FileGeometry record = at<FileGeometry>(file, begin);
      if (isInside(record.tree, record.treeBytes, file))
        record.treeChecksum = fileChecksum(&file[record.tree], record.treeBytes);
      if (isInside(record.blocks, record.blockBytes, file))
        record.blocksChecksum = fileChecksum(&file[record.blocks], record.blockBytes);
      std::memcpy(&file[begin], &record, sizeof(record));
    }
    header.directoryChecksum = fileChecksum(&file[header.directory], header.numGeometries * sizeof(FileGeometry));
  }
  header.checksum = fileChecksum(&header, offsetof(FileHeader, checksum));
  std::memcpy(&file[0], &header, sizeof(header));
}

// --- seeds -----------------------------------------------------------------------------------

// quads: per side of a geometry's only block
std::string fileOf(uint32_t quads, uint32_t numSteps, size_t numGeometries = 1) {
  const VertPlacement place(packRegion(quads, quads, 0, 0), packPatchQuads(quads, quads));
  std::vector<uint64_t> memory(MotionEncoder::maxBytes(numSteps) / 8 + 1);
  auto fill = [&](float(*vertices)[3], uint32_t step) {
    for (uint32_t v = 0; v < (quads + 1) * (quads + 1); v++) {
      vertices[v][0] = float(v % (quads + 1));
      vertices[v][1] = float(v / (quads + 1));
      vertices[v][2] = float(v * v % 5 + step) / 4;
    }
  };
  size_t bytes;
  if (numSteps > 1) {
    const auto encoder = std::make_unique<MotionEncoder>();
    encoder->begin(place, 0, 1, numSteps, (uint8_t*)memory.data());
    for (uint32_t step = 0; step < numSteps; step++) {
      fill(encoder->vertices(), step);
      encoder->addStep();
    }
    MotionStatistics statistics;
    bytes = encoder->finish(statistics);
  } else {
    const auto encoder = std::make_unique<VertEncoder>();
    fill(encoder->vertices, 0);
    VertStatistics statistics;
    bytes = encoder->encode(place, (uint8_t*)memory.data(), statistics);
  }
  FileSurface surface;
  surface.record.form = numSteps > 1 ? FILE_MOVING : FILE_LIST;
  surface.record.source = FILE_GRIDS;
  surface.record.compression = FILE_COMPRESSION_VERT;
  surface.record.numPrimitives = 1;
  surface.record.numTimeSteps = numSteps;
  surface.record.end = 1;
  surface.appendToList(memory.data(), uint32_t(bytes));

  char path[] = "/tmp/file_reading.XXXXXX";
  REQUIRE(mkdtemp(path));
  const std::string name = std::string(path) + "/seed.cbvh";
  FileWriter writer(name);
  for (size_t i = 0; i < numGeometries; i++) writer.add(surface);
  writer.commit();
  FILE* const file = std::fopen(name.c_str(), "rb");
  std::string content(1 << 20, 0);
  content.resize(std::fread(&content[0], 1, content.size(), file));
  std::fclose(file);
  REQUIRE(unlink(name.c_str()) == 0 && rmdir(path) == 0);
  return content;
}

// A list as a tree with one node.
std::string withTree(std::string file) {
  const FileHeader header = at<FileHeader>(file, 0);
  FileGeometry record = at<FileGeometry>(file, header.directory);
  const FileEntry entry = at<FileEntry>(file, record.tree);
  FileNode node = FileNode();
  node.children[0] = entry.child;
  for (int k = 0; k < 3; k++) {
    node.planes[k][0][0] = entry.lower[k];
    node.planes[k][1][0] = entry.upper[k];
  }
  record.form = FILE_TREE;
  record.treeBytes = sizeof(node);
  std::memcpy(&file[record.tree], &node, sizeof(node)); // the rest of its page is unused
  std::memcpy(&file[header.directory], &record, sizeof(record));
  return file;
}

// Both geometries have the same blocks, which is an error.
std::string withOverlap(std::string file) {
  const FileHeader header = at<FileHeader>(file, 0);
  const uint64_t second = header.directory + sizeof(FileGeometry);
  FileGeometry record = at<FileGeometry>(file, second);
  record.blocks = at<FileGeometry>(file, header.directory).blocks;
  std::memcpy(&file[second], &record, sizeof(record));
  return file;
}

// --- reading -----------------------------------------------------------------------------------

void decode(const VertHeader* block) {
  const uint32_t numSteps = isMoving(block->info) ? motionOf(block).numSteps : 1;
  for (uint32_t step = 0; step < numSteps; step++) std::make_unique<DecodedBlock>(block, step);
}

// Decodes the valid cVERT and mesh blocks. Returns their number plus the number of blocks with frames.
uint64_t decodeBlocks(const File& file, size_t i) {
  const FileGeometry& record = file.geometry(i);
  uint64_t valid = 0;
  const Reason reason = forEachBlock(record, file.tree(i), [&](FileChild type, uint64_t offset) {
    const char* const block = file.blocks(i) + offset;
    const size_t bytes = size_t(record.blockBytes - offset);
    if (isMesh(type)) {
      if (validateMeshBlock(record, block, bytes)) return;
      std::make_unique<DecodedMesh>((const MeshHeader*)block);
    } else if (type != FILE_FRAMED) {
      if (validateVertBlock(record, block, bytes)) return;
      decode((const VertHeader*)block);
    }
    valid++;
  });
  if (reason) REQUIRE(!reason.message().empty());
  return valid;
}

void requireDisjointBlocks(const File& file) {
  std::vector<std::pair<uint64_t, uint64_t>> ranges; // begin, end
  for (size_t i = 0; i < file.size(); i++) {
    const FileGeometry& record = file.geometry(i);
    if (record.blockBytes) ranges.emplace_back(record.blocks, record.blocks + record.blockBytes);
  }
  std::sort(ranges.begin(), ranges.end());
  for (size_t i = 1; i < ranges.size(); i++) REQUIRE(ranges[i - 1].second <= ranges[i].first);
}

void read(const std::string& bytes) {
  const MemoryFile memory(bytes);
  try {
    const File file(memory.path);
    requireDisjointBlocks(file);
    bool isVerified = true;
    try {
      file.verify();
    } catch (const Error& error) {
      isVerified = false;
      REQUIRE(std::string(error.what()).compare(0, memory.path.size(), memory.path) == 0);
    }
    for (size_t i = 0; i < file.size(); i++) {
      const uint64_t valid = decodeBlocks(file, i);
      REQUIRE(!isVerified || valid == file.geometry(i).numBlocks);
    }
  } catch (const Error& error) { REQUIRE(std::string(error.what()).compare(0, memory.path.size(), memory.path) == 0); }
}

} // namespace

void writeSeeds(const std::string& folder) {
  int n = 0;
  for (uint32_t quads : {1u, 5u, 16u})
    for (uint32_t numSteps : {1u, 3u}) {
      const std::string file = fileOf(quads, numSteps);
      writeSeed(folder + "/" + std::to_string(n++), file);
      if (numSteps == 1) writeSeed(folder + "/" + std::to_string(n++), withTree(file));
    }
  const std::string two = fileOf(5, 1, 2);
  writeSeed(folder + "/" + std::to_string(n++), two);
  writeSeed(folder + "/" + std::to_string(n++), withOverlap(two));
}

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string file((const char*)data, size);
  ::programs::test::seal(file);
  ::programs::test::read(file);
  return 0;
}
