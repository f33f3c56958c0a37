// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares docs/formats/file.md with the code: its tables, and a reader written only from the page. */

#include "kernels/cvert/format/motion.h"
#include "support/file_mutations.h"
#include "support/surface_access.h"

#include <functional>
#include <iomanip>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace programs::test { namespace {

using namespace cvert;

struct Field {
  size_t offset, bytes;
};

// Fields of the table below a heading, by name.
std::map<std::string, Field> tableOf(const std::string& heading) {
  std::string page = bytesOf(FILE_MD);
  const size_t begin = page.find("## " + heading + "\n");
  EXPECT_NE(begin, std::string::npos) << heading;
  page = page.substr(begin, page.find("\n## ", begin + 1) - begin);
  const std::regex row("\\| ([0-9]+) \\| (?:([0-9]+) )?(bytes|u32|u64|f32) \\| `([a-zA-Z]+)` \\|");
  std::map<std::string, Field> fields;
  for (std::sregex_iterator i(page.begin(), page.end(), row), end; i != end; ++i) {
    const size_t count = (*i)[2].matched ? std::stoul((*i)[2]) : 1, width = (*i)[3] == "u64"     ? 8
                                                                            : (*i)[3] == "bytes" ? 1
                                                                                                 : 4;
    fields[(*i)[4]] = {std::stoul((*i)[1]), count * width};
  }
  return fields;
}

#define EXPECT_FIELD(table, Struct, field) \
  do { \
    ASSERT_EQ(table.count(#field), 1u) << #field; \
    EXPECT_EQ(table[#field].offset, offsetof(Struct, field)) << #field; \
    EXPECT_EQ(table[#field].bytes, sizeof(Struct::field)) << #field; \
    table.erase(#field); \
  } while (false)

TEST(FileFormat, HeaderMatchesPage) {
  auto table = tableOf("Header");
  EXPECT_FIELD(table, FileHeader, magic);
  EXPECT_FIELD(table, FileHeader, byteOrder);
  EXPECT_FIELD(table, FileHeader, version);
  EXPECT_FIELD(table, FileHeader, vertVersion);
  EXPECT_FIELD(table, FileHeader, framedVersion);
  EXPECT_FIELD(table, FileHeader, numGeometries);
  EXPECT_FIELD(table, FileHeader, recordBytes);
  EXPECT_FIELD(table, FileHeader, fileBytes);
  EXPECT_FIELD(table, FileHeader, directory);
  EXPECT_FIELD(table, FileHeader, directoryChecksum);
  EXPECT_FIELD(table, FileHeader, key);
  EXPECT_FIELD(table, FileHeader, checksum);
  EXPECT_TRUE(table.empty()) << table.begin()->first;
}

TEST(FileFormat, RecordMatchesPage) {
  auto table = tableOf("Directory");
  EXPECT_FIELD(table, FileGeometry, tree);
  EXPECT_FIELD(table, FileGeometry, treeBytes);
  EXPECT_FIELD(table, FileGeometry, blocks);
  EXPECT_FIELD(table, FileGeometry, blockBytes);
  EXPECT_FIELD(table, FileGeometry, treeChecksum);
  EXPECT_FIELD(table, FileGeometry, blocksChecksum);
  EXPECT_FIELD(table, FileGeometry, form);
  EXPECT_FIELD(table, FileGeometry, source);
  EXPECT_FIELD(table, FileGeometry, compression);
  EXPECT_FIELD(table, FileGeometry, surface);
  EXPECT_FIELD(table, FileGeometry, numPrimitives);
  EXPECT_FIELD(table, FileGeometry, numTimeSteps);
  EXPECT_FIELD(table, FileGeometry, begin);
  EXPECT_FIELD(table, FileGeometry, end);
  EXPECT_FIELD(table, FileGeometry, lower);
  EXPECT_FIELD(table, FileGeometry, upper);
  EXPECT_FIELD(table, FileGeometry, numBlocks);
  EXPECT_FIELD(table, FileGeometry, measures);
  EXPECT_FIELD(table, FileGeometry, counts);
  EXPECT_FIELD(table, FileGeometry, reserved);
  EXPECT_TRUE(table.empty()) << table.begin()->first;
}

std::string hexadecimal(uint32_t number) {
  std::ostringstream text;
  text << "0x" << std::hex << std::setw(8) << std::setfill('0') << number;
  return text.str();
}

// The page must contain a table with these rows and no others. Prints the table to paste if it does not.
void expectTable(const std::string& head, const std::vector<std::pair<std::string, std::string>>& rows) {
  std::string table = head;
  for (const auto& [left, right] : rows) table += "| " + left + " | " + right + " |\n";
  EXPECT_NE(bytesOf(FILE_MD).find("\n\n" + table + "\n"), std::string::npos) << "file.md must contain\n" << table;
}

TEST(FileFormat, TablesOfNumbersMatchCode) {
  const auto text = [](uint64_t number) { return std::to_string(number); };
  expectTable("| constant | value |\n|:--|--:|\n",
              {{"version of the file", text(fileVersion)},
               {"version of cVERT blocks", text(vertFormatVersion)},
               {"version of cVERT blocks in a file with mesh blocks", text(meshFormatVersion)},
               {"version of cVERT blocks in a file with moving mesh blocks", text(movingMeshFormatVersion)},
               {"version of blocks with frames", text(fileFramedVersion)},
               {"bytes of the header", text(sizeof(FileHeader))},
               {"bytes of a record of the directory", text(sizeof(FileGeometry))},
               {"alignment of trees and blocks, bytes", text(filePage)},
               {"bytes after the blocks of a geometry, at least", text(fileReadPadding)},
               {"bytes of a node", text(sizeof(FileNode))},
               {"offset of the boxes in a node", text(offsetof(FileNode, planes))},
               {"bytes of an entry of a list", text(sizeof(FileEntry))},
               {"time steps of a geometry, at most", text(maxTimeSteps)},
               {"`byteOrder`", hexadecimal(fileByteOrder)},
               {"checksum of the characters `123456789`", hexadecimal(fileChecksum("123456789", 9))}});
  expectTable("| `form` | the tree consists of |\n|--:|---|\n", {{text(FILE_TREE), "nodes"},
                                                                 {text(FILE_LIST), "a list of blocks"},
                                                                 {text(FILE_MOVING), "a list of moving blocks"}});
  expectTable("| `source` | the geometry was made from |\n|--:|---|\n", {{text(FILE_CAGE), "a cage"},
                                                                         {text(FILE_GRIDS), "grids"},
                                                                         {text(FILE_QUADS), "quads"},
                                                                         {text(FILE_TRIANGLES), "triangles"}});
  expectTable("| type | child |\n|---|---|\n", {{text(FILE_NONE), "none"},
                                                {text(FILE_NODE), "a node"},
                                                {text(FILE_FRAMED), "a block with a frame"},
                                                {text(FILE_VERT), "a cVERT block"},
                                                {text(FILE_MOVING_VERT), "a moving cVERT block"},
                                                {text(FILE_MESH), "a mesh block"},
                                                {text(FILE_MOVING_MESH), "a moving mesh block"}});

  // Existing files contain these numbers.
  EXPECT_EQ(FILE_TREE, 0u);
  EXPECT_EQ(FILE_LIST, 1u);
  EXPECT_EQ(FILE_MOVING, 2u);
  EXPECT_EQ(FILE_CAGE, 0u);
  EXPECT_EQ(FILE_GRIDS, 1u);
  EXPECT_EQ(FILE_QUADS, 2u);
  EXPECT_EQ(FILE_TRIANGLES, 3u);
  EXPECT_EQ(FILE_NONE, 0u);
  EXPECT_EQ(FILE_NODE, 1u);
  EXPECT_EQ(FILE_FRAMED, 2u);
  EXPECT_EQ(FILE_VERT, 3u);
  EXPECT_EQ(FILE_MOVING_VERT, 4u);
  EXPECT_EQ(FILE_MESH, 5u);
  EXPECT_EQ(FILE_MOVING_MESH, 6u);
  EXPECT_EQ(crc32c("123456789", 9), 0xE3069283u);
}

TEST(FileFormat, ChecksumsMatchPageInEachForm) {
  Random random(3);
  std::string bytes;
  for (int i = 0; i < 1000; i++) bytes += char(random.below(256));
  for (size_t begin : {0, 1, 5})
    for (size_t count : {0, 1, 7, 8, 9, 63, 64, 900})
      for (bool isPortable : {false, true}) {
        const char* const data = bytes.data() + begin;
        ASSERT_EQ(fileChecksum(data, count, 0, isPortable), crc32c(data, count));
        ASSERT_EQ(fileChecksum(data + count / 3, count - count / 3, fileChecksum(data, count / 3, 0, !isPortable),
                               isPortable),
                  crc32c(data, count))
            << "computed in two parts";
      }
}

// Written only from the page: its offsets, and its rules for children.
class Reader {
public:
  explicit Reader(const std::string& bytes) : bytes(bytes) {}

  template<typename T> T at(uint64_t offset) const {
    T value = T();
    EXPECT_LE(offset + sizeof(T), bytes.size());
    if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, &bytes[offset], sizeof(T));
    return value;
  }
  uint32_t u32(uint64_t offset) const { return at<uint32_t>(offset); }
  uint64_t u64(uint64_t offset) const { return at<uint64_t>(offset); }

  void checkHeader() const {
    EXPECT_EQ(bytes.substr(0, 8), std::string("\x63\x62\x76\x68\x0d\x0a\x1a\x00", 8));
    EXPECT_EQ(u32(8), 0x01020304u);
    EXPECT_EQ(u64(32), bytes.size());
    EXPECT_EQ(u32(60), crc32c(&bytes[0], 60));
    EXPECT_EQ(u32(48), crc32c(&bytes[u64(40)], u32(24) * u32(28)));
  }

  // Offsets of blocks in the order of the tree, and their types.
  std::vector<std::pair<uint64_t, uint64_t>> blocksOf(uint64_t record) {
    const uint64_t tree = u64(record), treeBytes = u64(record + 8);
    EXPECT_EQ(tree % 4096, 0u);
    EXPECT_EQ(u64(record + 16) % 4096, 0u);
    EXPECT_EQ(u32(record + 32), crc32c(&bytes[tree], treeBytes));
    EXPECT_EQ(u32(record + 36), crc32c(&bytes[u64(record + 16)], u64(record + 24)));
    found.clear();
    if (u32(record + 40) == 0) {
      nextNode = 0;
      visit(tree, 1, 1);
      EXPECT_EQ(nextNode, treeBytes);
    } else
      for (uint64_t i = 0; i < treeBytes; i += 32) take(u64(tree + i + 24));
    return found;
  }

private:
  void visit(uint64_t tree, uint64_t child, unsigned depth) {
    EXPECT_LE(depth, 40u);
    const uint64_t at = child & ~uint64_t(15);
    ASSERT_EQ(at, nextNode);
    nextNode += 128;
    for (int i = 0; i < 4; i++) {
      const uint64_t below = u64(tree + at + 8 * i);
      for (int k = 0; k < 3 && below; k++)
        EXPECT_LE(this->at<float>(tree + at + 32 + 32 * k + 4 * i),
                  this->at<float>(tree + at + 32 + 32 * k + 16 + 4 * i));
      if ((below & 15) == 1) visit(tree, below, depth + 1);
      else if (below) take(below);
    }
  }

  void take(uint64_t child) {
    const uint64_t offset = child & ~uint64_t(15);
    if (!found.empty()) { EXPECT_GT(offset, found.back().first); }
    found.emplace_back(offset, child & 15);
  }

  const std::string& bytes;
  uint64_t nextNode = 0;
  std::vector<std::pair<uint64_t, uint64_t>> found;
};

TEST(FileFormat, ReaderWrittenFromPageFindsAllBlocks) {
  Folder folder;
  Device device;
  CbvhFileWriter writer = newFileWriter(device, (folder / "all").c_str());
  std::vector<size_t> quads;
  const std::vector<Saveable> all = allSaveable();
  for (const Saveable& saveable : all) {
    Scene scene(device);
    RTCGeometry geometry = saveable.make(device);
    EXPECT_TRUE(appendGeometry(writer, geometry)) << device.message;
    attach(scene, geometry);
    rtcCommitScene(scene);
    quads.push_back(statisticsOf(scene).numQuads);
  }
  ASSERT_TRUE(commitWriter(writer)) << device.message;
  releaseWriter(writer);
  const std::string bytes = bytesOf(folder / "all");
  Reader reader(bytes);
  reader.checkHeader();
  ASSERT_EQ(reader.u32(24), all.size());
  std::set<uint32_t> surfaces;
  std::set<uint32_t> forms;
  std::vector<std::pair<uint64_t, uint64_t>> ranges; // of blocks: begin, end
  bool hasMeshBlocks = false, hasMovingMeshBlocks = false;
  for (size_t i = 0; i < all.size(); i++) {
    SCOPED_TRACE(all[i].name);
    const uint64_t record = reader.u64(40) + i * reader.u32(28), blocks = reader.u64(record + 16),
                   blockBytes = reader.u64(record + 24);
    const uint32_t surface = reader.u32(record + 52);
    forms.insert(reader.u32(record + 40));
    EXPECT_TRUE(surface >> 30 & 1);
    EXPECT_EQ(surface >> 31 != 0, all[i].moves);
    EXPECT_TRUE(surfaces.insert(surface).second);
    const auto found = reader.blocksOf(record);
    EXPECT_EQ(found.size(), reader.u64(record + 96));
    EXPECT_LE(blocks + blockBytes + 64, bytes.size());
    for (const auto& [begin, end] : ranges) EXPECT_TRUE(blocks >= end || blocks + blockBytes <= begin);
    ranges.emplace_back(blocks, blocks + blockBytes);
    size_t sum = 0, triangles = 0;
    for (const auto& block : found) {
      const uint64_t at = blocks + block.first;
      const bool isVert = block.second != 2;
      EXPECT_LT(block.first, blockBytes);
      EXPECT_EQ(reader.u32(at + (isVert ? 16 : 12)), surface); // block.md, paper/README.md
      if (block.second == 5 || block.second == 6) {            // mesh.md
        triangles += (reader.u32(at + 48) >> 16 & 255) + 1;
        EXPECT_EQ(reader.u32(at + 28) != 0, block.second == 6);
        (block.second == 6 ? hasMovingMeshBlocks : hasMeshBlocks) = true;
        continue;
      }
      EXPECT_LT(reader.u32(at + (isVert ? 20 : 64)), reader.u32(record + 56));
      const uint32_t region = reader.u32(at + 24), height = reader.u32(at + 68) >> 4 & 15;
      sum += isVert ? ((region & 15) + 1) * ((region >> 4 & 15) + 1) : size_t(1) << 2 * height;
    }
    sum += (triangles + 1) / 2;
    EXPECT_EQ(sum, quads[i]);
    EXPECT_EQ(reader.u64(record + 120 + 8 * 6), quads[i]) << "numQuads of RTCCompressionStatistics";
  }
  EXPECT_EQ(forms.size(), 3u);
  EXPECT_TRUE(hasMeshBlocks);
  EXPECT_TRUE(hasMovingMeshBlocks);
  EXPECT_EQ(reader.u32(16), 7u);
  EXPECT_EQ(device.errors, 0u) << device.message;
}

// Readers that do not know a kind of block reject the file by the version of its blocks.
TEST(FileFormat, VersionOfBlocksIsTheOldestThatSuffices) {
  Folder folder;
  Device device;
  std::set<uint32_t> versions;
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "one").c_str())) << device.message;
    rtcReleaseGeometry(geometry);
    const std::string bytes = bytesOf(folder / "one");
    Reader reader(bytes);
    uint32_t expected = 5;
    for (const auto& block : reader.blocksOf(reader.u64(40)))
      if (block.second >= 5) expected = uint32_t(block.second) + 1;
    EXPECT_EQ(reader.u32(16), expected);
    versions.insert(expected);
  }
  EXPECT_EQ(versions, (std::set<uint32_t>{5, 6, 7}));
}

}} // namespace programs::test
