// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/representation.h"
#include "basics/error.h"
#include "basics/text.h"

#include "kernels/cbvh/base/kinds.h"

#include <algorithm>

namespace programs {
namespace {

struct Names {
  RepresentationKind kind;
  std::string optionName; // on command lines, in file names
  std::string label;      // in tables
  std::string config;     // of the device
  bool hasFrames;
  RTCCompression compression;
};

std::vector<Names> makeNames() {
  /* Explicit, because EMBREE_CBVH may select another representation. */
  std::vector<Names> names = {
      {RepresentationKind::Naive, "naive", "NAIVE", "", false, RTC_COMPRESSION_NONE},
      {RepresentationKind::NaiveCompact, "naive-compact", "NAIVE-compact", "", false, RTC_COMPRESSION_NONE},
      {RepresentationKind::Grid, "grid", "GRID", "subdiv_accel=bvh4.grid.eager", false, RTC_COMPRESSION_NONE}};
  for (const embree::cbvh::KindDescription& kind : embree::cbvh::kindDescriptions) {
    const std::string key = kind.key;
    names.push_back({RepresentationKind(kind.compression()), "c" + key, kind.name, "subdiv_accel=cbvh." + key,
                     kind.hasFrame(), kind.compression()});
    if (names.back().kind != RepresentationKind::CLeaf) continue;
    /* Explicit, because EMBREE_CBVH may set it. */
    Names only = names.back();
    only.kind = RepresentationKind::CLeafOnly;
    only.optionName += "-only";
    only.label += "-only";
    only.config += ",cbvh_fallback_faces=0";
    names.back().config += ",cbvh_fallback_faces=1";
    names.push_back(only);
  }
  return names;
}

const std::vector<Names>& allNames() {
  static const std::vector<Names> names = makeNames();
  return names;
}

const Names& namesOf(RepresentationKind kind) {
  const std::vector<Names>& names = allNames();
  return *std::find_if(names.begin(), names.end(), [=](const Names& n) { return n.kind == kind; });
}

/* `name` is in lower case. */
bool isNameOf(const Names& names, const std::string& name) {
  if (name == names.optionName) return true;
  if (names.compression == RTC_COMPRESSION_NONE) return false;
  const std::string key = names.optionName.substr(1); // without "c"
  return name == "cbvh." + key || (name == key && name != namesOf(RepresentationKind::Grid).optionName);
}

/* Empty unless the frame level is explicit. */
std::string frameLevelAfter(const char* mark, const Representation& r) {
  return r.hasFrames() && r.frameLevel != autoFrameLevel ? mark + std::to_string(r.frameLevel) : "";
}

} // namespace

const int maxLevel = int(embree::cbvh::maxFramedLevel);

const std::vector<RepresentationKind>& representationKinds() {
  static const std::vector<RepresentationKind> kinds = [] {
    std::vector<RepresentationKind> all;
    for (const Names& names : allNames()) all.push_back(names.kind);
    return all;
  }();
  return kinds;
}

const std::string& labelOf(RepresentationKind kind) { return namesOf(kind).label; }

const std::string& optionNameOf(RepresentationKind kind) { return namesOf(kind).optionName; }

std::string listOfRepresentations(const std::string& separator, const std::string& last) {
  std::string list;
  for (const Names& names : allNames())
    list += (list.empty() ? "" : &names == &allNames().back() ? last : separator) + names.optionName;
  return list;
}

std::string defaultRepresentations() {
  std::string list;
  for (const Names& names : allNames())
    if (names.kind != RepresentationKind::CLeafOnly) list += (list.empty() ? "" : ",") + names.optionName;
  return list;
}

std::string meshRepresentations() {
  return optionNameOf(RepresentationKind::Grid) + "," + optionNameOf(RepresentationKind::NaiveCompact) + "," +
         optionNameOf(RepresentationKind::CVert) + "," + optionNameOf(RepresentationKind::CTile);
}

std::string levelRange() { return "0 to " + std::to_string(maxLevel); }

bool Representation::hasFrames() const { return namesOf(kind).hasFrames; }

std::string Representation::replacementInMotion() const {
  if (!hasFrames()) return "";
  /* Without fallback faces, the library leaves motion to GRID. */
  return kind == RepresentationKind::CLeafOnly ? labelOf(RepresentationKind::Grid)
                                               : "stored as " + labelOf(RepresentationKind::CVert);
}

bool Representation::isTriangulated() const {
  return kind == RepresentationKind::Naive || kind == RepresentationKind::NaiveCompact;
}

std::string Representation::label() const { return namesOf(kind).label + frameLevelAfter("^", *this); }

std::string Representation::fileStem() const { return namesOf(kind).optionName + frameLevelAfter("", *this); }

RTCCompression Representation::compression() const { return namesOf(kind).compression; }

std::string Representation::deviceConfig() const {
  std::string config = namesOf(kind).config;
  if (hasFrames())
    config += ",cbvh_frame_level=" + (frameLevel == autoFrameLevel ? "auto" : std::to_string(frameLevel));
  return config;
}

RTCSceneFlags Representation::sceneFlags() const {
  return kind == RepresentationKind::NaiveCompact ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE;
}

int parseFrameLevel(const std::string& text) {
  if (text == "auto") return autoFrameLevel;
  if (text.size() == 1 && text[0] >= '0' && text[0] <= '0' + maxLevel) return text[0] - '0';
  throw Error("invalid frame level '" + text + "': expected " + levelRange() + " or auto");
}

std::vector<Representation> parseRepresentations(const std::string& list, int defaultFrameLevel) {
  std::vector<Representation> result;
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(',', begin), list.size());
    const std::string word = list.substr(begin, end - begin);
    begin = end + 1;

    const size_t mark = word.find_first_of("^:");
    const std::string name = lowerCase(word.substr(0, mark));
    const std::vector<Names>& names = allNames();
    const auto found = std::find_if(names.begin(), names.end(), [&](const Names& n) { return isNameOf(n, name); });
    if (found == names.end())
      throw Error("unknown representation '" + word + "': expected " + listOfRepresentations(", ", " or "));

    Representation r{found->kind, defaultFrameLevel};
    if (mark != std::string::npos) {
      if (!r.hasFrames())
        throw Error("representation '" + word + "': " + name + " has no frame level: expected " + name + " alone");
      r.frameLevel = parseFrameLevel(word.substr(mark + 1));
    }
    for (const Representation& other : result)
      if (other.label() == r.label())
        throw Error("representation '" + word + "' is repeated: expected each representation once");
    result.push_back(r);
  }
  return result;
}

} // namespace programs
