// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_modes.h"
#include "basics/error.h"

#include <iterator>

namespace programs {
namespace {

constexpr const char* queryNames[numQueries] = {"closest", "any"};
constexpr const char* modeNames[] = {"single", "packet4", "packet8", "packet16", "stream"};

} // namespace

const char* queryName(Query query) { return queryNames[query]; }

const char* traceModeName(TraceMode mode) { return modeNames[size_t(mode)]; }

Query parseQuery(const std::string& name) {
  for (int i = 0; i < numQueries; i++)
    if (name == queryNames[i]) return Query(i);
  throw Error("unknown query '" + name + "': expected closest or any");
}

TraceMode parseTraceMode(const std::string& name) {
  for (size_t i = 0; i < std::size(modeNames); i++)
    if (name == modeNames[i]) return TraceMode(i);
  throw Error("unknown mode '" + name + "': expected single, packet4, packet8, packet16 or stream");
}

} // namespace programs
