// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/ply_header.h"

#include <iterator>
#include <utility>

namespace programs {

int PlyElement::find(const char* property) const {
  for (size_t i = 0; i < properties.size(); i++)
    if (properties[i].name == property) return int(i);
  return -1;
}

size_t PlyElement::leastBytes(PlyFormat format) const {
  if (format == PlyFormat::Ascii) return 2 * properties.size(); // a digit, and a blank or line end
  size_t bytes = 0;
  for (const PlyProperty& p : properties) bytes += sizeOf(p.isList ? p.countType : p.type);
  return bytes;
}

namespace {

/* Old names, and those of newer programs. */
constexpr std::pair<const char*, PlyType> plyTypes[] = {
    {"char", PlyType::Int8},      {"int8", PlyType::Int8},       {"uchar", PlyType::UInt8},
    {"uint8", PlyType::UInt8},    {"short", PlyType::Int16},     {"int16", PlyType::Int16},
    {"ushort", PlyType::UInt16},  {"uint16", PlyType::UInt16},   {"int", PlyType::Int32},
    {"int32", PlyType::Int32},    {"uint", PlyType::UInt32},     {"uint32", PlyType::UInt32},
    {"float", PlyType::Float32},  {"float32", PlyType::Float32}, {"double", PlyType::Float64},
    {"float64", PlyType::Float64}};

class PlyHeaderReader {
public:
  explicit PlyHeaderReader(InputBytes& input) : input(input) {}

  PlyHeader run() {
    readLine();
    if (line != "ply") fail(std::string(quotedWord(line)) + " is no PLY file: expected 'ply' in the first line");
    readFormat();
    for (;;) {
      readLine();
      std::string_view rest = line;
      const std::string_view word = nextWord(rest);
      if (word == "end_header") return std::move(header);
      if (word == "comment" || word == "obj_info") header.comments += std::string(rest) + "\n";
      else if (word == "element") readElement(rest);
      else if (word == "property") readProperty(rest);
      else if (!word.empty()) fail("unknown word " + quotedWord(word) + ": expected element, property or end_header");
    }
  }

private:
  [[noreturn]] void fail(const std::string& what) const { input.failAtLine(what); }

  /* Binary data may begin with a byte that looks like the second half of CR LF. */
  void readLine() {
    constexpr size_t longest = 65536;
    line.clear();
    input.countLine();
    for (;;) {
      if (input.require(1) == 0) fail("the file ends within the header: expected 'end_header'");
      const char c = char(*input.data());
      input.skip(1);
      if (c == '\n') break;
      if (c == '\r') {
        if (input.lineNumber() == 1) endsWithTwo = input.require(1) && *input.data() == '\n';
        if (endsWithTwo && input.require(1) && *input.data() == '\n') input.skip(1);
        break;
      }
      if (line.size() == longest) fail("the line is too long: expected the header of a PLY file");
      line += c;
    }
    line.erase(line.find_last_not_of(" \t") + 1);
  }

  void readFormat() {
    do readLine(); // comments may precede it
    while (line.empty() || line.rfind("comment", 0) == 0 || line.rfind("obj_info", 0) == 0);
    std::string_view rest = line;
    const std::string_view word = nextWord(rest), format = nextWord(rest), version = nextWord(rest);
    const char* const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (size_t i = 0; i < std::size(names); i++)
      if (word == "format" && format == names[i] && version == "1.0" && nextWord(rest).empty()) {
        header.format = PlyFormat(i);
        return;
      }
    fail(quotedWord(line) + " is not supported: expected 'format' with ascii, binary_little_endian or "
                            "binary_big_endian, and 1.0");
  }

  void readElement(std::string_view rest) {
    PlyElement element;
    element.name = nextWord(rest);
    const std::string_view count = nextWord(rest);
    int64_t value = 0;
    if (!parseInteger(count, value) || value < 0 || !nextWord(rest).empty())
      fail("element " + quotedWord(element.name) + " has the count " + quotedWord(count) +
           ": expected a number of 0 or more");
    for (const PlyElement& other : header.elements)
      if (other.name == element.name) fail("a second element " + quotedWord(element.name) + ": expected one");
    element.count = uint64_t(value);
    header.elements.push_back(std::move(element));
  }

  PlyType type(std::string_view word) const {
    for (const auto& [name, type] : plyTypes)
      if (word == name) return type;
    fail("unknown type " + quotedWord(word) +
         ": expected char, uchar, short, ushort, int, uint, float, double, or "
         "int8 to float64");
  }

  void readProperty(std::string_view rest) {
    if (header.elements.empty()) fail("a property without an element: expected 'element' before");
    PlyElement& element = header.elements.back();
    PlyProperty property;
    std::string_view word = nextWord(rest);
    property.isList = word == "list";
    if (property.isList) {
      property.countType = type(nextWord(rest));
      if (!isInteger(property.countType)) fail("the count of a list is no integer: expected uchar, int or the like");
      word = nextWord(rest);
    }
    property.type = type(word);
    property.name = nextWord(rest);
    if (property.name.empty() || !nextWord(rest).empty())
      fail(quotedWord(line) + " is no property: expected a type and a name");
    if (element.find(property.name.c_str()) >= 0)
      fail("a second property " + quotedWord(property.name) + " of element " + quotedWord(element.name) +
           ": expected one");
    element.properties.push_back(std::move(property));
  }

  InputBytes& input;
  PlyHeader header;
  std::string line;
  bool endsWithTwo = false; // lines end in CR LF
};

} // namespace

PlyHeader readPlyHeader(InputBytes& input) { return PlyHeaderReader(input).run(); }

} // namespace programs
