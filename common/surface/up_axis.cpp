// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/up_axis.h"
#include "basics/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <unordered_set>

namespace programs {
namespace {

/* --- evidence in comments ---------------------------------------------------------------- */

/* Lower-case words. Punctuation becomes a word, so "forward -Z, up Y" does not contain "z up". */
std::vector<std::string> wordsOf(const std::string& text) {
  std::vector<std::string> words{""};
  for (const char c : lowerCase(text)) {
    if (std::isalnum((unsigned char)c)) words.back() += c;
    else if (c == '\n' || c == ',' || c == ';' || c == '.') words.insert(words.end(), {std::string(1, c), ""});
    else if (!words.back().empty()) words.push_back("");
  }
  words.erase(std::remove(words.begin(), words.end(), ""), words.end());
  return words;
}

/* Any of "z up", "z axis up", "up: z", "up axis: z", "upaxis z". */
bool namesUpAxis(const std::vector<std::string>& words, const std::string& axis) {
  const std::vector<std::vector<std::string>> phrases = {{axis, "up"}, {axis, "axis", "up"}, {axis + "up"},
                                                         {"up", axis}, {"up", "axis", axis}, {"upaxis", axis}};
  return std::any_of(phrases.begin(), phrases.end(), [&](const std::vector<std::string>& phrase) {
    return std::search(words.begin(), words.end(), phrase.begin(), phrase.end()) != words.end();
  });
}

/* Name themselves in files and always export z up, unlike Blender and 3ds Max, which convert to y up by default. */
constexpr std::array<const char*, 2> zUpPrograms = {"FreeCAD", "OpenSCAD"};

/* --- evidence in the shape --------------------------------------------------------------- */

using Point = std::array<float, 3>;

class Shape {
public:
  /* Ignores vertices without faces. */
  explicit Shape(const Cage& cage) : cage(cage) {
    std::vector<char> used(cage.positions.size());
    for (const unsigned i : cage.faceIndices) used[i] = 1;
    for (size_t i = 0; i < used.size(); i++)
      if (used[i]) points.push_back({cage.positions[i].x, cage.positions[i].y, cage.positions[i].z});
    for (size_t axis = 0; axis < 3; axis++) {
      const auto isLess = [=](const Point& a, const Point& b) { return a[axis] < b[axis]; };
      const auto [least, most] = std::minmax_element(points.begin(), points.end(), isLess);
      lower[axis] = (*least)[axis];
      upper[axis] = (*most)[axis];
      double sum = 0;
      for (const Point& p : points) sum += p[axis];
      mean[axis] = float(sum / double(points.size()));
    }
  }

  float extent(size_t axis) const { return upper[axis] - lower[axis]; }
  float middle(size_t axis) const { return 0.5f * (lower[axis] + upper[axis]); }

  bool isFlat() const { return !(std::min({extent(0), extent(1), extent(2)}) > 0.0f); }

  /* True if the lowest point is at 0, where modelers place the ground. */
  bool startsAtZero(size_t axis) const { return std::abs(lower[axis]) <= 0.01f * extent(axis); }

  /* True if the shape extends to both sides of 0: no ground there. */
  bool isAboutZero(size_t axis) const { return std::min(-lower[axis], upper[axis]) >= 0.2f * extent(axis); }

  /* True if the shape would stand with this axis upwards: its center is above its lowest points, which spread over
   * at least 15% of its width and depth. (Arms that are held out are five times as wide as the feet.) */
  bool standsOn(size_t axis) const {
    const std::vector<Point> base = lowest(axis);
    for (const size_t other : {(axis + 1) % 3, (axis + 2) % 3}) {
      const auto isLess = [=](const Point& a, const Point& b) { return a[other] < b[other]; };
      const auto [least, most] = std::minmax_element(base.begin(), base.end(), isLess);
      const float begin = (*least)[other], end = (*most)[other];
      if (!(end - begin >= 0.15f * extent(other) && begin < mean[other] && mean[other] < end)) return false;
    }
    return true;
  }

  /* True if the lowest points are left and right of the middle without points or faces between them: feet, not the
   * open rim of a mask or the butt of a gun. */
  bool hasFeet(size_t axis, size_t sideways) const {
    const auto sideOf = [&](const Point& p) { // -1, 1, or 0 near the middle
      const float from = (p[sideways] - middle(sideways)) / extent(sideways);
      return from < -0.02f ? -1 : from > 0.02f ? 1 : 0;
    };
    for (const Point& p : lowest(axis))
      if (sideOf(p) == 0) return false;
    size_t first = 0;
    for (const unsigned size : cage.faceSizes) {
      int sides = 0; // bits: left, right
      for (size_t i = first; i < first + size; i++) {
        const Vec3f v = cage.positions[cage.faceIndices[i]];
        const Point p{v.x, v.y, v.z};
        if (isLowest(p, axis)) sides |= sideOf(p) < 0 ? 1 : 2;
      }
      if (sides == 3) return false;
      first += size;
    }
    return true;
  }

  /* True if 98% of the vertices have a mirror image. */
  bool isMirrored(size_t axis) const {
    const float cell = 0.005f * std::max({extent(0), extent(1), extent(2)});
    const auto place = [&](const Point& p, size_t i) { return int64_t(std::floor((p[i] - lower[i]) / cell)); };
    const auto key = [](int64_t x, int64_t y, int64_t z) { return uint64_t((x + 1) << 20 | (y + 1) << 10 | (z + 1)); };
    std::unordered_set<uint64_t> occupied;
    for (const Point& p : points) occupied.insert(key(place(p, 0), place(p, 1), place(p, 2)));
    constexpr size_t most = 10000; // vertices to test
    const size_t step = points.size() / most + 1;
    size_t seen = 0, found = 0;
    for (size_t i = 0; i < points.size(); i += step) {
      Point p = points[i];
      p[axis] = 2.0f * middle(axis) - p[axis];
      bool partner = false;
      for (int n = 0; n < 27 && !partner; n++)
        partner = occupied.count(key(place(p, 0) + n % 3 - 1, place(p, 1) + n / 3 % 3 - 1, place(p, 2) + n / 9 - 1));
      found += partner;
      seen++;
    }
    return double(found) >= 0.98 * double(seen);
  }

private:
  /* 2% of the height, because soles are not flat. */
  bool isLowest(const Point& p, size_t axis) const { return p[axis] <= lower[axis] + 0.02f * extent(axis); }

  std::vector<Point> lowest(size_t axis) const {
    std::vector<Point> base;
    std::copy_if(points.begin(), points.end(), std::back_inserter(base),
                 [&](const Point& p) { return isLowest(p, axis); });
    return base;
  }

  const Cage& cage;
  std::vector<Point> points;
  Point lower, upper, mean;
};

/* Reason for z up, or empty. */
std::string evidenceInShape(const Cage& cage) {
  constexpr size_t x = 0, y = 1, z = 2;
  const Shape shape(cage);
  if (shape.isFlat() || !shape.startsAtZero(z) || !shape.isAboutZero(y) || !shape.standsOn(z) || shape.isMirrored(z))
    return "";
  /* Standing objects rarely look the same upside down. Objects that are thin along z may hang on a wall; objects
   * that are thin along y may lie on the ground. */
  if (shape.isMirrored(y)) {
    const bool isThin = shape.extent(z) < 0.4f * std::max(shape.extent(x), shape.extent(y)) ||
                        shape.extent(y) < 0.25f * std::max(shape.extent(x), shape.extent(z));
    return isThin ? "" : "it stands on the plane z = 0 and is its own mirror image along y";
  }
  /* Figures and furniture are symmetric. */
  if (shape.isMirrored(x) && shape.hasFeet(z, x) && !shape.standsOn(y) && shape.extent(z) >= 0.5f * shape.extent(y))
    return "it stands on feet on the plane z = 0";
  return "";
}

/* --- rotation ---------------------------------------------------------------------------- */

Vec3f rotated(Vec3f v, const std::string& up) {
  if (up == "x") return {v.y, -v.x, v.z};
  if (up == "-x") return {-v.y, v.x, v.z};
  if (up == "-y") return {-v.x, -v.y, v.z};
  if (up == "z") return {v.x, -v.z, v.y};
  if (up == "-z") return {v.x, v.z, -v.y};
  return v;
}

} // namespace

const std::vector<std::string>& upAxes() {
  static const std::vector<std::string> axes = {"y", "z", "x", "-y", "-z", "-x"};
  return axes;
}

UpGuess guessUp(const Cage& cage) {
  const std::vector<std::string> words = wordsOf(cage.comments);
  const bool y = namesUpAxis(words, "y"), z = namesUpAxis(words, "z");
  if (y != z) return z ? UpGuess{"z", "a comment at the beginning of the file names it"} : UpGuess{};
  for (const char* program : zUpPrograms)
    if (std::find(words.begin(), words.end(), lowerCase(program)) != words.end())
      return {"z", std::string("the file was written by ") + program + ", where z is up"};
  const std::string evidence = evidenceInShape(cage);
  return evidence.empty() ? UpGuess{} : UpGuess{"z", evidence};
}

ViewHints rotatedFromY(ViewHints hints, const std::string& up) {
  hints.direction = rotated(hints.direction, up);
  hints.up = rotated(hints.up, up);
  return hints;
}

/* The inverse of a quarter turn is the opposite one; a half turn is its own inverse. */
ViewHints rotatedToY(ViewHints hints, const std::string& up) {
  const bool isQuarter = up.back() != 'y';
  return rotatedFromY(hints, isQuarter ? (up[0] == '-' ? up.substr(1) : "-" + up) : up);
}

} // namespace programs
