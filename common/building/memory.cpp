// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/memory.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

namespace programs {
namespace {

/* Names in the file systems of control groups. */
struct GroupVersion {
  const char *controllers, *folder, *limit, *used, *prefix;
};
constexpr GroupVersion groupVersions[] = {
    {"", "/sys/fs/cgroup", "/memory.max", "/memory.current", ""},
    {"memory", "/sys/fs/cgroup/memory", "/memory.limit_in_bytes", "/memory.usage_in_bytes", "total_"}};

/* Path of the process's group, or empty for the root. */
std::string groupOf(const std::string& root, const GroupVersion& version) {
  std::ifstream groups(root + "/proc/self/cgroup");
  const std::string mark = ":" + std::string(version.controllers) + ":/";
  for (std::string line; std::getline(groups, line);) // for example 0::/user.slice
    if (const size_t at = line.find(':'); at != std::string::npos && line.compare(at, mark.size(), mark) == 0) {
      const std::string path = line.substr(at + mark.size());
      return path.empty() ? "" : "/" + path;
    }
  return "";
}

/* Bytes until a group reaches its limit. The kernel frees cached files on demand, but counts them as used. */
size_t bytesLeft(const std::string& group, const GroupVersion& version) {
  std::ifstream limitFile(group + version.limit), usedFile(group + version.used), statistics(group + "/memory.stat");
  size_t limit = 0, used = 0, cached = 0;
  if (!(limitFile >> limit && usedFile >> used)) // fails for "max": no limit
    return SIZE_MAX;
  const std::string prefix = version.prefix;
  std::string key;
  for (size_t bytes = 0; statistics >> key >> bytes;)
    if (key == prefix + "active_file" || key == prefix + "inactive_file") cached += bytes;
  used -= std::min(used, cached);
  return limit > used ? limit - used : 0;
}

} // namespace

size_t estimatedPeakBytes(RepresentationKind kind, const BuildSize& size) {
  const size_t quads = size.quads, later = size.timeSteps - 1;
  switch (kind) // bytes per quad, for the first and for each later time step
  {
  case RepresentationKind::Naive: return quads * (265 + 30 * later);        // measured without motion: 246
  case RepresentationKind::NaiveCompact: return quads * (205 + 30 * later); // measured: 194
  case RepresentationKind::Grid: return quads * (45 + 25 * later);
  case RepresentationKind::CTile: return quads * (14 + 8 * later);
  case RepresentationKind::CGrid:
    if (later == 0) return quads * 25;
    [[fallthrough]]; // in motion: cVERT
  default: return quads * (10 + 6 * later);
  }
}

size_t availableMemory(const std::string& root) {
  size_t available = SIZE_MAX;
  std::ifstream meminfo(root + "/proc/meminfo");
  for (std::string key, rest; meminfo >> key && std::getline(meminfo, rest);)
    if (key == "MemAvailable:")
      available = std::min(available, size_t(std::strtoull(rest.c_str(), nullptr, 10)) * 1024);
  for (const GroupVersion& version : groupVersions)
    for (std::string group = groupOf(root, version);; group.erase(group.rfind('/'))) {
      available = std::min(available, bytesLeft(root + version.folder + group, version));
      if (group.empty()) break;
    }
  return available;
}

size_t bytesInLargePages() {
  std::ifstream sums("/proc/self/smaps_rollup");
  for (std::string line; std::getline(sums, line);) // for example "AnonHugePages:  2048 kB"
    if (line.compare(0, 14, "AnonHugePages:") == 0) return size_t(std::strtoull(line.c_str() + 14, nullptr, 10)) << 10;
  return 0;
}

} // namespace programs
