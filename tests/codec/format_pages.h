// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace programs::test {

// Names of texts that are not in docs/formats, relative to it.
inline constexpr const char* paperPage = "../../kernels/cbvh/paper/README.md";
inline constexpr const char* annotatedBlocks = "../../tests/codec/annotated_blocks.txt";

inline std::string page(const std::string& name) {
  std::ifstream file(FORMATS "/" + name);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_FALSE(text.empty()) << name;
  return text;
}

// Returns a section of a page, up to the next heading of its level.
inline std::string section(const std::string& name, const std::string& heading) {
  const std::string all = page(name);
  const size_t begin = all.find("\n## " + heading + "\n"), end = all.find("\n## ", begin + 1);
  EXPECT_NE(begin, std::string::npos) << name << " has no section " << heading;
  return begin == std::string::npos ? "" : all.substr(begin, end - begin);
}

struct Constant {
  const char* name;
  double value;
};

// The page must have a table of exactly these constants.
inline void expectConstants(const std::string& name, const std::vector<Constant>& constants) {
  std::ostringstream table;
  table << "| constant | value |\n|:--|--:|\n";
  for (const Constant& constant : constants) table << "| " << constant.name << " | " << constant.value << " |\n";
  EXPECT_NE(page(name).find("-->\n\n" + table.str() + "\n"), std::string::npos) << name << " must contain\n"
                                                                                << table.str();
}

// Rows "| offset | type | `field` | meaning |" of a section must have these fields, consecutively from begin to end.
inline void expectRows(const std::string& name, const std::string& heading,
                       const std::map<std::string, size_t>& offsetOf, size_t begin, size_t end) {
  const std::map<std::string, size_t> bytesOf = {{"float", 4},         {"float[3]", 12}, {"float[3][4]", 48},
                                                 {"uint32", 4},        {"uint32[2]", 8}, {"uint16[4]", 8},
                                                 {"uint16[4][3]", 24}, {"int8[8]", 8},   {"uint8[16]", 16}};
  const std::string text = section(name, heading);
  const std::regex row("\\| ([0-9]+) \\| ([a-z0-9\\[\\]]+) \\| `([A-Za-z]+)` \\|");
  size_t rows = 0, at = begin;
  for (std::sregex_iterator i(text.begin(), text.end(), row), last; i != last; ++i, rows++) {
    const size_t offset = std::stoul((*i)[1]);
    const std::string field = (*i)[3];
    EXPECT_EQ(offset, at) << field;
    ASSERT_EQ(offsetOf.count(field), 1u) << field;
    EXPECT_EQ(offset, offsetOf.at(field)) << field;
    at = offset + bytesOf.at((*i)[2]);
  }
  EXPECT_EQ(rows, offsetOf.size());
  EXPECT_EQ(at, end);
}

// Returns the bytes of an annotated block, from rows "| offset | `bytes` | meaning" of its section. Offsets must be
// consecutive.
inline std::vector<uint8_t> annotatedBytes(const std::string& heading) {
  std::istringstream lines(section(annotatedBlocks, heading));
  std::vector<uint8_t> bytes;
  for (std::string line; std::getline(lines, line);) {
    unsigned offset;
    if (std::sscanf(line.c_str(), "| %u | `", &offset) != 1) continue;
    EXPECT_EQ(offset, bytes.size()) << line;
    const size_t begin = line.find('`') + 1;
    std::istringstream row(line.substr(begin, line.find('`', begin) - begin));
    for (unsigned byte; row >> std::hex >> byte;) bytes.push_back(uint8_t(byte));
  }
  return bytes;
}

inline std::string wordsOf(const std::vector<uint8_t>& bytes) {
  std::ostringstream text;
  for (size_t i = 0; i < bytes.size(); i++) {
    char byte[4];
    std::snprintf(byte, sizeof(byte), "%02x ", bytes[i]);
    if (i % 4 == 0) text << (i ? "\n" : "") << i << ": ";
    text << byte;
  }
  return text.str();
}

inline void expectAnnotatedBytes(const void* block, size_t size, const std::string& heading) {
  const uint8_t* const bytes = (const uint8_t*)block;
  EXPECT_EQ(wordsOf({bytes, bytes + size}), wordsOf(annotatedBytes(heading)));
}

} // namespace programs::test
