// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks device strings such as "threads=4,isa=avx2", because Embree ignores unknown keys and many invalid values.
 * Also finds similar names, for messages. Independent of Embree, because the interposer compiles it, too.
 * Thread-safe. */

#include <string>
#include <vector>

namespace embree {
/*! True for Embree's keys and the cbvh keys. */
bool isDeviceKey(const std::string& key);

/*! Returns "cbvh_" + name if it is a key, otherwise nearestName() of all keys. For messages. */
std::string nearestDeviceKey(const std::string& name);

/*! Returns the first of `names` that begins with `name`, otherwise the most similar one. names: not empty. */
std::string nearestName(const std::string& name, const std::vector<std::string>& names);

/*! Checks all keys, and values whose errors Embree ignores. Returns an empty string, or a message with the first
 *  invalid key and a similar valid one, or with the first invalid value and what is accepted. deviceString: may be
 *  null. */
std::string findDeviceStringError(const char* deviceString);
} // namespace embree
