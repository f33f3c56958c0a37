// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/udim_tiles.h"
#include "basics/error.h"
#include "basics/input_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <system_error>

namespace programs {
namespace {

constexpr const char* placeholder = "<UDIM>";
constexpr int columns = 10;

/* Placeholders, with OpenImageIO's meaning. */
struct Placeholder {
  const char* spelling;
  std::string (*text)(int column, int row);
};

std::string udim(int column, int row) { return std::to_string(1001 + column + columns * row); }

const Placeholder placeholders[] = {
    {"<UDIM>", udim},
    {"<udim>", udim},
    {"%(UDIM)d", udim},
    {"<UVTILE>", [](int x, int y) { return "u" + std::to_string(x + 1) + "_v" + std::to_string(y + 1); }},
    {"<uvtile>", [](int x, int y) { return "u" + std::to_string(x) + "_v" + std::to_string(y); }},
    {"<U>", [](int x, int) { return "u" + std::to_string(x + 1); }},
    {"<V>", [](int, int y) { return "v" + std::to_string(y + 1); }},
    {"<u>", [](int x, int) { return "u" + std::to_string(x); }},
    {"<v>", [](int, int y) { return "v" + std::to_string(y); }},
};

struct FaceExtent {
  Vec2f tile;           // at the middle of the face
  bool isWithin = true; // no corner is outside of that tile
};

std::vector<FaceExtent> extentsOf(const Cage& cage) {
  std::vector<FaceExtent> extents;
  size_t corner = 0;
  for (unsigned size : cage.faceSizes) {
    Vec2f sum, lower{INFINITY, INFINITY}, upper{-INFINITY, -INFINITY};
    for (unsigned i = 0; i < size; i++) {
      const Vec2f uv = cage.uvs[cage.uvIndices[corner++]];
      sum = sum + uv;
      lower = {std::min(lower.x, uv.x), std::min(lower.y, uv.y)};
      upper = {std::max(upper.x, uv.x), std::max(upper.y, uv.y)};
    }
    const Vec2f middle = sum * (1.0f / float(size));
    constexpr float tolerance = 1e-4f; // in tiles, for rounded coordinates
    FaceExtent extent;
    extent.tile = {std::floor(middle.x), std::floor(middle.y)};
    extent.isWithin = lower.x >= extent.tile.x - tolerance && lower.y >= extent.tile.y - tolerance &&
                      upper.x <= extent.tile.x + 1.0f + tolerance && upper.y <= extent.tile.y + 1.0f + tolerance;
    extents.push_back(extent);
  }
  return extents;
}

std::string replaced(std::string path, const std::string& from, const std::string& to) {
  for (size_t at = path.find(from); at != std::string::npos; at = path.find(from, at + to.size()))
    path.replace(at, from.size(), to);
  return path;
}

std::string pathOfTile(std::string path, int number) {
  for (const Placeholder& p : placeholders)
    path = replaced(path, p.spelling, p.text((number - 1001) % columns, (number - 1001) / columns));
  return path;
}

bool fileExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

/* Returns the path with other placeholders if the tile has a file of that name, or empty. */
std::string otherSpelling(const std::string& path, int number) {
  const char* const spellings[] = {"<UDIM>",  "%(UDIM)d", "<UVTILE>", "<uvtile>",
                                   "<U>_<V>", "<u>_<v>",  "<U><V>",   "<u><v>"};
  /* <U> and <u> include the letter, which other programs expect in front of them. */
  std::string single = path;
  for (const char* letters : {"uU", "vV"})
    for (const char* letter = letters; *letter; letter++)
      for (const char* inner = letters; *inner; inner++)
        single = replaced(single, std::string(1, *letter) + "<" + *inner + ">", std::string("<") + *inner + ">");
  for (const std::string& start : {path, single})
    for (const char* from : spellings)
      for (const char* to : spellings)
        if (const std::string other = replaced(start, from, to);
            other != path && isUdimPath(other) && fileExists(pathOfTile(other, number)))
          return other;
  return "";
}

/* The placeholders' meaning for a tile. */
std::string expectedPlaceholders(int number) {
  std::string text;
  for (const char* spelling : {"<UDIM>", "<UVTILE>", "<uvtile>"})
    text += (text.empty() ? "" : ", ") + std::string(spelling) + " is " + pathOfTile(spelling, number);
  return text;
}

int numberOf(Vec2f tile) {
  constexpr float maxRows = 900; // numbers have four digits
  if (!(tile.x >= 0.0f && tile.x < columns && tile.y >= 0.0f && tile.y < maxRows)) return 0;
  return 1001 + int(tile.x) + columns * int(tile.y);
}

/* Warns if faces lie on several tiles, one each, but the map is a single file. */
void warnOfTiles(const Cage& cage, const std::vector<FaceExtent>& extents, const std::string& path,
                 std::string& warnings) {
  int least = 0, most = 0;
  for (const FaceExtent& e : extents) {
    const int number = numberOf(e.tile);
    if (!e.isWithin || number == 0) return;
    least = least == 0 ? number : std::min(least, number);
    most = std::max(most, number);
  }
  if (least != most)
    warnings += cage.name + " is laid out in UDIM tiles, " + std::to_string(least) + " to " + std::to_string(most) +
                ", but " + path + " repeats on each tile; expected " + placeholder + " in the path, as in skin." +
                placeholder + ".png, if each tile has its own map\n";
}

std::string faces(size_t n) { return std::to_string(n) + (n == 1 ? " face" : " faces"); }

} // namespace

bool isUdimPath(const std::string& path) {
  return !fileExists(path) && std::any_of(std::begin(placeholders), std::end(placeholders), [&](const Placeholder& p) {
    return path.find(p.spelling) != std::string::npos;
  });
}

void recordMapFiles(const Cage& cage, const std::string& path) {
  std::string ignored;
  const bool isUdim = isUdimPath(path);
  for (const std::string& file : isUdim ? UdimTiles::find(cage, path, ignored).paths : std::vector<std::string>{path})
    recordInputFile(file);
}

UdimTiles UdimTiles::find(const Cage& cage, const std::string& path, std::string& warnings) {
  const std::vector<FaceExtent> extents = extentsOf(cage);
  UdimTiles tiles;
  if (!isUdimPath(path)) {
    warnOfTiles(cage, extents, path, warnings);
    tiles.paths = {path};
    return tiles;
  }
  std::map<int, int> imageOfNumber; // -1: no file
  std::map<int, size_t> missing;    // faces per tile without a file
  size_t across = 0;
  for (const FaceExtent& e : extents) {
    const int number = numberOf(e.tile);
    const auto [entry, isNew] = imageOfNumber.try_emplace(number, -1);
    if (isNew && number && fileExists(pathOfTile(path, number))) {
      entry->second = int(tiles.paths.size());
      tiles.paths.push_back(pathOfTile(path, number));
    }
    if (entry->second < 0) missing[number]++;
    else across += !e.isWithin;
    tiles.images.push_back(entry->second);
    tiles.origins.push_back(e.tile);
  }
  if (tiles.paths.empty() && missing.rbegin()->first == 0)
    throw Error(path + ": the texture coordinates of " + cage.name + " lie outside of all tiles: expected 0 to " +
                std::to_string(columns) + " across, 0 or more upwards");
  if (tiles.paths.empty()) {
    int number = missing.rbegin()->first;
    std::string other;
    for (auto tile = missing.rbegin(); tile != missing.rend() && tile->first && other.empty(); ++tile) {
      other = otherSpelling(path, tile->first);
      number = other.empty() ? number : tile->first;
    }
    throw Error(path + ": no such height map: " + cage.name + " uses, for example, tile " + std::to_string(number) +
                ", but there is no " + pathOfTile(path, number) +
                (other.empty() ? ": expected this file, or another placeholder (" + expectedPlaceholders(number) + ")"
                               : "; " + pathOfTile(other, number) + " exists: expected " + other));
  }
  for (const auto& [number, count] : missing) {
    const std::string other = number ? otherSpelling(path, number) : "";
    const std::string reason =
        number ? "there is no tile " + std::to_string(number) + " (" + pathOfTile(path, number) + ")"
               : "texture coordinates lie outside of all tiles";
    warnings += path + ": " + reason + ", " + faces(count) + " of " + cage.name + (count == 1 ? " is" : " are") +
                " not displaced" +
                (other.empty() ? "" : "; " + pathOfTile(other, number) + " exists: expected " + other) + "\n";
  }
  if (across)
    warnings += cage.name + ": " + faces(across) + (across == 1 ? " crosses" : " cross") +
                " the border of a UDIM tile and read only the tile at the middle\n";
  return tiles;
}

} // namespace programs
