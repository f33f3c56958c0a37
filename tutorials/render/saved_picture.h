// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A picture of what --save wrote. */

#include "options.h"

namespace cbvh {

/* Opens options.loadPath, writes the picture, and says on standard output what there is and how long it took. Throws Error, Cancelled. */
void renderSaved(const Options& options);

} // namespace cbvh
