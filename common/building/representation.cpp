// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/representation.h"
#include "basics/error.h"

#include <algorithm>
#include <cctype>

namespace cbvh {
namespace {

struct Names
{
  RepresentationKind kind;
  const char* word;   // command line, file names
  const char* label;  // tables
  const char* accel;  // device string
  RTCCompression compression;
};

constexpr Names names[] = {
  {RepresentationKind::Naive, "naive", "NAIVE", "", RTC_COMPRESSION_NONE},
  {RepresentationKind::Grid, "grid", "GRID", "bvh4.grid.eager", RTC_COMPRESSION_NONE},
  {RepresentationKind::CGrid, "cgrid", "cGRID", "cbvh.grid", RTC_COMPRESSION_GRID},
  {RepresentationKind::CVoxel, "cvoxel", "cVOXEL", "cbvh.voxel", RTC_COMPRESSION_VOXEL},
  {RepresentationKind::CLeaf, "cleaf", "cLEAF", "cbvh.leaf", RTC_COMPRESSION_LEAF},
  {RepresentationKind::CVert, "cvert", "cVERT", "cbvh.vert", RTC_COMPRESSION_VERT},
};

const Names& namesOf(RepresentationKind kind)
{
  return names[size_t(kind)];
}

std::string frameLevelText(int frameLevel)
{
  return frameLevel == autoFrameLevel ? "auto" : std::to_string(frameLevel);
}

} // namespace

std::string Representation::label() const
{
  return namesOf(kind).label + (hasFrames() ? "^" + frameLevelText(frameLevel) : "");
}

std::string Representation::fileStem() const
{
  return namesOf(kind).word + (hasFrames() ? frameLevelText(frameLevel) : "");
}

RTCCompression Representation::compression() const
{
  return namesOf(kind).compression;
}

std::string Representation::deviceConfig() const
{
  /* GRID is asked for by name: EMBREE_CBVH may say otherwise. */
  if (kind == RepresentationKind::Naive)
    return "";
  std::string config = std::string("subdiv_accel=") + namesOf(kind).accel;
  if (hasFrames())
    config += ",cbvh_frame_level=" + frameLevelText(frameLevel);
  return config;
}

int parseFrameLevel(const std::string& text)
{
  if (text == "auto")
    return autoFrameLevel;
  if (text.size() == 1 && text[0] >= '0' && text[0] <= '0' + maxLevel)
    return text[0] - '0';
  throw Error("frame level '" + text + "' is neither auto nor 0 to " + std::to_string(maxLevel));
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
    const auto found = std::find_if(std::begin(names), std::end(names), [&](const Names& n) { return name == n.word; });
    if (found == std::end(names))
      throw Error("unknown representation '" + word + "', known are naive, grid, cgrid, cvoxel, cleaf and cvert");

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
