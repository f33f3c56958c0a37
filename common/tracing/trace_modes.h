// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The queries of Embree's API. */

#include <cstddef>
#include <string>

namespace cbvh {

enum Query { Closest, Any, numQueries };

/* Rays per call. A packet consists of consecutive rays of the set; the last one may have inactive lanes. */
enum class TraceMode { Single, Packet4, Packet8, Packet16, Stream };

constexpr size_t streamSize = 1024;

/* Return names such as "closest"; "single", "packet4", "stream". */
const char* queryName(Query query);
const char* traceModeName(TraceMode mode);

/* The inverse functions. Throw Error. */
Query parseQuery(const std::string& name);
TraceMode parseTraceMode(const std::string& name);

} // namespace cbvh
