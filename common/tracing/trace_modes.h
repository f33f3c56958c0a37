// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

namespace programs {

enum Query { Closest, Any, numQueries };

/* Rays per call. Packets consist of consecutive rays; the last one may have inactive lanes. */
enum class TraceMode { Single, Packet4, Packet8, Packet16, Stream };

constexpr size_t streamSize = 1024;

/* "closest" or "any"; "single", "packet4", "stream" and so on. */
const char* queryName(Query query);
const char* traceModeName(TraceMode mode);

/* Inverses. Throw Error. */
Query parseQuery(const std::string& name);
TraceMode parseTraceMode(const std::string& name);

} // namespace programs
