// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/representation.h"
#include "basics/error.h"

#include "kernels/cbvh/base/kinds.h"

#include <algorithm>
#include <cctype>

namespace cbvh {
namespace {

struct Names
{
  RepresentationKind kind;
  std::string word;   // command line, file names
  std::string label;  // tables
  std::string accel;  // device string
  bool hasFrames;
};

std::vector<Names> makeNames()
{
  std::vector<Names> names = {{RepresentationKind::Naive, "naive", "NAIVE", "", false},
                              {RepresentationKind::Grid, "grid", "GRID", "bvh4.grid.eager", false}};
  for (const embree::cbvh::KindDescription& kind : embree::cbvh::kindDescriptions)
  {
    const std::string key = kind.key;
    names.push_back({RepresentationKind(kind.compression()), "c" + key, kind.name, "cbvh." + key, kind.hasFrame()});
  }
  return names;
}

const std::vector<Names>& allNames()
{
  static const std::vector<Names> names = makeNames();
  return names;
}

const Names& namesOf(RepresentationKind kind)
{
  const std::vector<Names>& names = allNames();
  return *std::find_if(names.begin(), names.end(), [=](const Names& n) { return n.kind == kind; });
}

/* Behind the name of a kind with frames: nothing for the level that the library chooses. */
std::string frameLevelAfter(const char* mark, const Representation& r)
{
  return r.hasFrames() && r.frameLevel != autoFrameLevel ? mark + std::to_string(r.frameLevel) : "";
}

} // namespace

const int maxLevel = int(embree::cbvh::maxLevel);

const std::vector<RepresentationKind>& representationKinds()
{
  static const std::vector<RepresentationKind> kinds = [] {
    std::vector<RepresentationKind> all;
    for (const Names& names : allNames())
      all.push_back(names.kind);
    return all;
  }();
  return kinds;
}

const std::string& labelOf(RepresentationKind kind)
{
  return namesOf(kind).label;
}

const std::string& wordOf(RepresentationKind kind)
{
  return namesOf(kind).word;
}

std::string listOfRepresentations(const std::string& between, const std::string& last)
{
  std::string list;
  for (const Names& names : allNames())
    list += (list.empty() ? "" : &names == &allNames().back() ? last : between) + names.word;
  return list;
}

std::string levelRange()
{
  return "0 to " + std::to_string(maxLevel);
}

bool Representation::hasFrames() const
{
  return namesOf(kind).hasFrames;
}

std::string Representation::label() const
{
  return namesOf(kind).label + frameLevelAfter("^", *this);
}

std::string Representation::fileStem() const
{
  return namesOf(kind).word + frameLevelAfter("", *this);
}

RTCCompression Representation::compression() const
{
  return kind == RepresentationKind::Naive || kind == RepresentationKind::Grid ? RTC_COMPRESSION_NONE : RTCCompression(kind);
}

std::string Representation::deviceConfig() const
{
  /* GRID is asked for by name: EMBREE_CBVH may say otherwise. */
  if (kind == RepresentationKind::Naive)
    return "";
  std::string config = "subdiv_accel=" + namesOf(kind).accel;
  if (hasFrames())
    config += ",cbvh_frame_level=" + (frameLevel == autoFrameLevel ? "auto" : std::to_string(frameLevel));
  return config;
}

int parseFrameLevel(const std::string& text)
{
  if (text == "auto")
    return autoFrameLevel;
  if (text.size() == 1 && text[0] >= '0' && text[0] <= '0' + maxLevel)
    return text[0] - '0';
  throw Error("frame level '" + text + "' is neither auto nor " + levelRange());
}

std::vector<Representation> parseRepresentations(const std::string& list, int defaultFrameLevel)
{
  std::vector<Representation> result;
  for (size_t begin = 0; begin <= list.size();)
  {
    const size_t end = std::min(list.find(',', begin), list.size());
    const std::string word = list.substr(begin, end - begin);
    begin = end + 1;

    const size_t mark = word.find_first_of("^:");
    std::string name = word.substr(0, mark);
    for (char& c : name)
      c = char(std::tolower(static_cast<unsigned char>(c)));
    const std::vector<Names>& names = allNames();
    const auto found = std::find_if(names.begin(), names.end(), [&](const Names& n) { return name == n.word; });
    if (found == names.end())
      throw Error("unknown representation '" + word + "', known are " + listOfRepresentations(", ", " and "));

    Representation r{found->kind, defaultFrameLevel};
    if (mark != std::string::npos)
    {
      if (!r.hasFrames())
        throw Error("representation '" + word + "': " + name + " has no frame level");
      r.frameLevel = parseFrameLevel(word.substr(mark + 1));
    }
    for (const Representation& other : result)
      if (other.label() == r.label())
        throw Error("representation '" + word + "' is named twice");
    result.push_back(r);
  }
  return result;
}

} // namespace cbvh
