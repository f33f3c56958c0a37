// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Warnings about models and representations, one per line. */

#include "basics/text.h"
#include "building/representation.h"
#include "surface/model.h"
#include "surface/seam_gaps.h"

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace programs {

inline std::string prefixLines(const std::string& prefix, const std::string& warnings) {
  std::istringstream lines(warnings);
  std::string all;
  for (std::string line; std::getline(lines, line);) all += prefix + line + "\n";
  return all;
}

/* Names each representation that does not support motion, and what the library builds instead. Empty for static
 * models. */
inline std::string motionWarnings(const Model& model, const std::vector<Representation>& representations) {
  std::string lines;
  if (model.poses.empty()) return lines;
  for (const Representation& r : representations) {
    const std::string replacement = r.replacementInMotion();
    const std::string line = optionNameOf(r.kind) + " is " + replacement + ", because blocks with frames do not move\n";
    if (!replacement.empty() && lines.find(line) == std::string::npos) // the same for all frame levels
      lines += line;
  }
  return lines;
}

/* Empty unless a gap exceeds a quad. */
inline std::string seamWarnings(const Model& model, const SeamGap& seams) {
  if (!(seams.quads > 1.0f)) return "";
  return model.name + ": the displacements of neighboring faces differ by up to " + shortNumber(seams.distance) +
         " where they meet, which is " + shortNumber(std::round(10.0f * seams.quads) / 10.0f) + " quads at face " +
         std::to_string(seams.face) +
         " (from 0); the surface uses their mean: expected a map that agrees at seams within less than a quad\n";
}

inline void printWarnings(const std::string& program, const std::string& warnings) {
  std::fputs(prefixLines(program + ": warning: ", warnings).c_str(), stderr);
}

} // namespace programs
