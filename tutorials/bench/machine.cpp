// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "machine.h"
#include "basics/error.h"
#include "build_info.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sstream>
#include <sys/utsname.h>
#include <thread>
#include <unistd.h>

namespace programs {
namespace {

std::string processorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0 && line.find(':') != std::string::npos)
      return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

bool processorHas(const std::string& isa) {
#if !defined(__x86_64__)
  return isa == "sse2"; // Embree's name for NEON
#else
  if (isa == "sse2") return __builtin_cpu_supports("sse2");
  if (isa == "sse4.2") return __builtin_cpu_supports("sse4.2");
  if (isa == "avx") return __builtin_cpu_supports("avx");
  if (isa == "avx2") return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#endif
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream stream(list);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

} // namespace

Machine describeMachine() {
  Machine m;
  m.cpu = processorName();
  m.threads = std::max(1u, std::thread::hardware_concurrency());
  m.memoryBytes = size_t(sysconf(_SC_PHYS_PAGES)) * size_t(sysconf(_SC_PAGESIZE));
  getloadavg(&m.load, 1);
  utsname names;
  if (uname(&names) == 0) m.system = std::string(names.sysname) + " " + names.release + " " + names.machine;
  m.commit = CBVH_BUILD_COMMIT;
  m.compiler = CBVH_BUILD_COMPILER;
  m.flags = CBVH_BUILD_FLAGS;
  m.buildType = CBVH_BUILD_TYPE;
  m.isas = split(CBVH_BUILD_ISAS);
  m.date = dateNow();
  return m;
}

std::string dateNow() {
  char text[32];
  const std::time_t now = std::time(nullptr);
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
  return text;
}

std::vector<std::string> usableIsas(const Machine& machine) {
  std::vector<std::string> usable;
  for (const std::string& isa : machine.isas) // narrowest first
    if (processorHas(isa)) usable.push_back(isa);
  return usable;
}

std::string bestIsa(const Machine& machine) {
  const std::vector<std::string> usable = usableIsas(machine);
  if (usable.empty())
    throw Error("--isa best: this processor has none of the instruction sets that the library, or all libraries of "
                "--library, were built for: expected a library for this processor");
  return usable.back();
}

void requireIsa(const Machine& machine, const std::string& isa) {
  const std::vector<std::string> known{"sse2", "sse4.2", "avx", "avx2", "avx512"};
  if (std::find(known.begin(), known.end(), isa) == known.end())
    throw Error("unknown --isa '" + isa + "': expected best, sse2, sse4.2, avx, avx2 or avx512");
  if (std::find(machine.isas.begin(), machine.isas.end(), isa) == machine.isas.end())
    throw Error("--isa '" + isa +
                "': the library, or one of --library, was not built for it: expected one that all "
                "libraries have");
  if (!processorHas(isa))
    throw Error("--isa '" + isa + "': this processor does not have it: expected best, or one that --about lists");
}

} // namespace programs
