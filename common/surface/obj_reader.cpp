// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Tags are as in OpenSubdiv's regression shapes: `t name ints/floats/strings`, followed by that many values.
 * Vertices and faces in tags are numbered from 0.
 *
 * tinyobjloader (2.0.0rc10 of Debian 12) reads the tags, but misreads some files without an error: it drops the
 * first vertex after a byte order mark, reads `v 1 x 2` and NaN as vertices, skips unknown statements, keeps 8 bits
 * of the number of corners, and rejects faces that continue on the next line. This reader is also faster. */

#include "surface/obj_reader.h"
#include "basics/error.h"
#include "basics/open_input.h"
#include "basics/progress.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <set>
#include <string_view>
#include <type_traits>

namespace programs {
namespace {

class Parser {
public:
  Parser(std::istream& stream, const std::string& name, std::string& warnings, std::vector<Vec3d>* exactPositions)
    : stream(stream),
      name(name),
      warnings(warnings),
      exactPositions(exactPositions) {}

  Cage run() {
    cage.name = name;
    for (std::string line; readLine(line);) {
      if (lineNumber == 1 && line.compare(0, 3, "\xEF\xBB\xBF") == 0)
        line.erase(0, 3); // byte order mark of Windows programs
      while (continues(line)) {
        line.back() = ' ';
        std::string more;
        if (!readLine(more)) break;
        line += more;
      }
      statement(line);
    }
    finish();
    return std::move(cage);
  }

private:
  /* Reads a line that ends in LF, CR LF or CR, without trailing blanks. Returns false at the end of the file. */
  bool readLine(std::string& line) {
    line.clear();
    try {
      std::streambuf& from = *stream.rdbuf();
      int c = from.sbumpc();
      if (c == EOF) return false;
      for (; c != EOF && c != '\n' && c != '\r'; c = from.sbumpc()) line += char(c);
      if (c == '\r' && from.sgetc() == '\n') from.sbumpc();
    } catch (const std::ios_base::failure&) { throw Error(name + ": read error"); }
    line.erase(line.find_last_not_of(" \t") + 1);
    if (lineNumber++ % 4096 == 0) throwIfCanceled();
    return true;
  }

  /* Comments and names never continue on the next line: a Windows path may end in a backslash. */
  static bool continues(std::string_view line) {
    if (line.empty() || line.back() != '\\' || line.find('#') != std::string_view::npos) return false;
    static const std::set<std::string_view> named = {"g",      "o",      "usemtl",     "mtllib",
                                                     "usemap", "maplib", "shadow_obj", "trace_obj"};
    const size_t begin = line.find_first_not_of(" \t");
    const std::string_view kind = line.substr(begin, std::min(line.find_first_of(" \t\\", begin), line.size()) - begin);
    return !named.count(kind);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(name + ":" + std::to_string(lineNumber) + ": " + what);
  }

  /* True in 1.#INF and -1.#IND00, which old C libraries of Windows write. */
  static bool isPartOfNumber(std::string_view rest) {
    const std::string_view kinds[] = {".#INF", ".#IND", ".#QNAN", ".#SNAN"};
    return std::any_of(std::begin(kinds), std::end(kinds),
                       [&](std::string_view kind) { return rest.substr(0, kind.size()) == kind; });
  }

  static std::vector<std::string_view> split(std::string_view line) {
    std::vector<std::string_view> words;
    for (size_t i = 0; i < line.size();) {
      const size_t begin = line.find_first_not_of(" \t\r\n", i);
      if (begin == std::string_view::npos || line[begin] == '#') break;
      size_t end = std::min(line.find_first_of(" \t\r\n#", begin), line.size());
      if (isPartOfNumber(line.substr(end - 1))) end = std::min(line.find_first_of(" \t\r\n", end), line.size());
      words.push_back(line.substr(begin, end - begin));
      i = end;
    }
    return words;
  }

  static std::string printable(std::string_view word) {
    constexpr size_t longest = 32;
    std::string text(word.substr(0, longest));
    for (char& c : text)
      if (c < ' ' || c > '~') c = '?';
    return text + (word.size() > longest ? "..." : "");
  }

  static std::string quoted(std::string_view word) { return "'" + printable(word) + "'"; }

  template<typename T>
  T number(std::string_view word) const {
    std::string_view digits = word;
    if (!digits.empty() && digits[0] == '+') digits.remove_prefix(1);
    T value{};
    const char* const last = digits.data() + digits.size();
    const auto [end, code] = std::from_chars(digits.data(), last, value);
    if (code == std::errc::result_out_of_range && end == last) return outOfRange<T>(word);
    if (code != std::errc() || end != last) fail("expected a number, found " + quoted(word));
    return value;
  }

  /* Tiny coordinates of programs that compute in doubles become 0. */
  template<typename T>
  T outOfRange(std::string_view word) const {
    if constexpr (std::is_floating_point_v<T>)
      if (std::abs(std::strtod(std::string(word).c_str(), nullptr)) < 1.0) return 0;
    fail(quoted(word) + " is too large; expected a value that a float or an index can hold");
  }

  float coordinate(std::string_view word) const {
    const float value = number<float>(word);
    if (!std::isfinite(value)) fail(quoted(word) + " is not finite: expected a finite number");
    return value;
  }

  unsigned index(std::string_view word, size_t count, const char* what) const {
    const long long value = number<long long>(word);
    const long long zeroBased = value < 0 ? (long long)count + value : value - 1;
    if (value == 0 || zeroBased < 0 || zeroBased >= (long long)count)
      fail(std::string(what) + " index " + std::string(word) + " is out of range: the file has " +
           std::to_string(count) + " before this line");
    return unsigned(zeroBased);
  }

  void statement(std::string_view line) {
    const std::vector<std::string_view> words = split(line);
    if (words.empty()) return comment(line);
    atHead = false;
    const std::string_view kind = words[0];
    if (kind == "v") {
      if (words.size() < 4) fail("a vertex needs three coordinates, this one has " + std::to_string(words.size() - 1));
      cage.positions.push_back({coordinate(words[1]), coordinate(words[2]), coordinate(words[3])});
      if (exactPositions)
        exactPositions->push_back({number<double>(words[1]), number<double>(words[2]), number<double>(words[3])});
    } else if (kind == "vt") {
      if (words.size() < 2) fail("expected one or two numbers after 'vt', found none");
      const float v = words.size() < 3 ? 0.0f : coordinate(words[2]);
      cage.uvs.push_back({coordinate(words[1]), v});
    } else if (kind == "f") face(words);
    else if (kind == "t") tag(words);
    else {
      static const std::set<std::string_view> skipped = {
          "vn",     "vp",     "g",  "o",   "s",     "l",        "p",        "usemtl",     "mtllib",
          "usemap", "maplib", "mg", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"};
      if (!skipped.count(kind))
        fail("unknown statement " + quoted(kind) +
             (lineNumber == 1 ? ": expected an OBJ file" : ": expected a statement of OBJ"));
    }
  }

  /* Programs describe themselves in comments before the first statement. */
  void comment(std::string_view line) {
    constexpr size_t longest = 4096;
    const size_t begin = line.find('#');
    if (atHead && begin != std::string_view::npos && cage.comments.size() + line.size() < longest)
      cage.comments += std::string(line.substr(begin + 1)) + "\n";
  }

  void face(const std::vector<std::string_view>& words) {
    const size_t corners = words.size() - 1;
    if (corners < 3) fail("a face needs at least three vertices, this one has " + std::to_string(corners));
    std::vector<unsigned> uvs; // of the corners with texture coordinates
    for (size_t i = 1; i <= corners; i++) {
      const std::string_view word = words[i];
      const size_t slash = word.find('/');
      cage.faceIndices.push_back(index(word.substr(0, slash), cage.positions.size(), "vertex"));
      std::string_view uv;
      if (slash != std::string_view::npos) {
        uv = word.substr(slash + 1);
        uv = uv.substr(0, uv.find('/'));
      }
      if (!uv.empty()) uvs.push_back(index(uv, cage.uvs.size(), "texture coordinate"));
    }
    cage.faceSizes.push_back(unsigned(corners));
    addTextureCoordinates(uvs, corners);
  }

  /* uvIndices stays empty until the first face with texture coordinates. */
  void addTextureCoordinates(const std::vector<unsigned>& uvs, size_t corners) {
    if (!uvs.empty() && uvs.size() != corners)
      fail("a face needs texture coordinates at all corners or at none, this one has them at " +
           std::to_string(uvs.size()) + " of " + std::to_string(corners));
    if (uvs.empty() && cage.lineWithoutUVs == 0) cage.lineWithoutUVs = lineNumber;
    if (uvs.empty() && cage.uvIndices.empty()) return;
    cage.uvIndices.resize(cage.faceIndices.size() - uvs.size(), Cage::noUV);
    cage.uvIndices.insert(cage.uvIndices.end(), uvs.begin(), uvs.end());
  }

  /* t NAME INTS/FLOATS/STRINGS VALUES */
  struct Tag {
    std::string name;
    std::vector<unsigned> ints;
    std::vector<float> floats;
    std::vector<std::string> strings;
  };

  Tag readTag(const std::vector<std::string_view>& words) const {
    if (words.size() < 3) fail("expected a name and counts after 't', as in 't crease 2/1/0'");
    size_t counts[3] = {0, 0, 0};
    std::string_view rest = words[2];
    for (int i = 0; i < 3; i++) {
      const size_t slash = rest.find('/');
      counts[i] = number<unsigned>(rest.substr(0, slash));
      if (slash == std::string_view::npos) {
        rest = {};
        break;
      }
      rest = rest.substr(slash + 1);
    }
    if (words.size() != 3 + counts[0] + counts[1] + counts[2])
      fail("tag " + quoted(words[1]) + " declares " + printable(words[2]) + " values, but has " +
           std::to_string(words.size() - 3));
    Tag tag;
    tag.name = words[1];
    for (size_t i = 0; i < counts[0]; i++) tag.ints.push_back(number<unsigned>(words[3 + i]));
    for (size_t i = 0; i < counts[1]; i++) {
      const float sharpness = number<float>(words[3 + counts[0] + i]);
      if (!(sharpness >= 0.0f))
        fail("sharpness " + printable(words[3 + counts[0] + i]) + " is " +
             (sharpness < 0.0f ? "negative" : "not a number") + "; expected 0 or more");
      tag.floats.push_back(sharpnessOf(sharpness));
    }
    tag.strings.assign(words.end() - ptrdiff_t(counts[2]), words.end());
    return tag;
  }

  float sharpness(const Tag& tag, size_t i, size_t n) const {
    if (tag.floats.size() != 1 && tag.floats.size() != n)
      fail("tag '" + tag.name + "' has " + std::to_string(tag.floats.size()) + " values of sharpness; expected 1 or " +
           std::to_string(n));
    return tag.floats.size() == 1 ? tag.floats[0] : tag.floats[i];
  }

  static std::string rule(const Tag& tag) { return tag.strings.empty() ? "" : tag.strings[0]; }

  CreaseRule creaseRule(const Tag& tag) const {
    if (rule(tag) == "chaikin") return CreaseRule::Chaikin;
    if (rule(tag) != "normal" && rule(tag) != "uniform")
      fail("unknown method " + quoted(rule(tag)) + " of tag 'creasemethod'; expected normal or chaikin");
    return CreaseRule::Uniform;
  }

  void tag(const std::vector<std::string_view>& words) {
    const Tag tag = readTag(words);
    const std::vector<unsigned>& ints = tag.ints;
    if (tag.name == "crease") {
      if (ints.size() < 2 || ints.size() % 2)
        fail("tag 'crease' has " + std::to_string(ints.size()) + " vertices; expected pairs of vertices");
      for (size_t i = 0; i < ints.size() / 2; i++) {
        cage.creaseEdges.push_back({ints[2 * i], ints[2 * i + 1]});
        cage.creaseSharpness.push_back(sharpness(tag, i, ints.size() / 2));
      }
    } else if (tag.name == "corner")
      for (size_t i = 0; i < ints.size(); i++) {
        cage.cornerVertices.push_back(ints[i]);
        cage.cornerSharpness.push_back(sharpness(tag, i, ints.size()));
      }
    else if (tag.name == "hole") cage.holes.insert(cage.holes.end(), ints.begin(), ints.end());
    else if (tag.name == "interpolateboundary") {
      if (ints.size() != 1 || ints[0] > 2)
        fail("tag 'interpolateboundary' has " +
             (ints.size() == 1 ? "the value " + std::to_string(ints[0]) : std::to_string(ints.size()) + " values") +
             "; expected one value: 0, 1 or 2");
      cage.boundary = BoundaryRule(ints[0]);
    } else if (tag.name == "creasemethod") cage.creaseRule = creaseRule(tag);
    else if (tag.name == "smoothtriangles") {
      if (rule(tag) != "normal" && rule(tag) != "catmark")
        warnings += name + ":" + std::to_string(lineNumber) + ": tag 'smoothtriangles " + printable(rule(tag)) +
                    "' is ignored: Embree supports only the normal rule\n";
    } else if (tag.name.substr(0, 11) != "facevarying") // smoothing of texture coordinates, which stay linear here
      fail("unknown tag " + quoted(tag.name) + ": expected crease, corner, hole, interpolateboundary or creasemethod");
  }

  /* At the end, because tags may precede the faces and vertices that they refer to. */
  void finish() {
    if (cage.faceSizes.empty()) throw Error(name + ": no faces; expected at least one 'f' statement");
    if (cage.uvIndices.empty()) {
      cage.uvs.clear();
      cage.lineWithoutUVs = 0;
    }
    auto check = [&](unsigned value, size_t count, const char* what) {
      if (value >= count)
        throw Error(name + ": a tag refers to " + what + " " + std::to_string(value) + ", but the file has " +
                    std::to_string(count) + ", counted from 0");
    };
    for (auto [a, b] : cage.creaseEdges) {
      check(a, cage.positions.size(), "vertex");
      check(b, cage.positions.size(), "vertex");
    }
    for (unsigned v : cage.cornerVertices) check(v, cage.positions.size(), "vertex");
    for (unsigned f : cage.holes) check(f, cage.faceSizes.size(), "face");
  }

  std::istream& stream;
  std::string name;
  std::string& warnings;
  std::vector<Vec3d>* exactPositions; // or null
  Cage cage;
  size_t lineNumber = 0;
  bool atHead = true;
};

} // namespace

Cage readObj(std::istream& stream, const std::string& name, std::string& warnings, std::vector<Vec3d>* exactPositions) {
  return Parser(stream, name, warnings, exactPositions).run();
}

Cage readObj(const std::string& path, std::string& warnings, std::vector<Vec3d>* exactPositions) {
  return readObj(*openInput(path), path, warnings, exactPositions);
}

} // namespace programs
