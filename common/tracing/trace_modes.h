// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The entrances of Embree's API that rays are traced through. */

#include <cstddef>
#include <string>

namespace cbvh {

enum Query { Closest, Any, numQueries };

/* How many rays a call takes. A packet is made of consecutive rays of the set, the
 * last one filled up with inactive lanes. */
enum class TraceMode { Single, Packet4, Packet8, Packet16, Stream };

constexpr size_t streamSize = 1024;

/* "closest"; "single", "packet4", "stream". */
const char* queryName(Query query);
const char* traceModeName(TraceMode mode);

/* The inverse. Throws Error. */
Query parseQuery(const std::string& name);
TraceMode parseTraceMode(const std::string& name);

} // namespace cbvh
