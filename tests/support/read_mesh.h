// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/error.h"
#include "meshes/mesh_file.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace programs::test {

/* The name selects the format. */
inline PolygonMesh meshOf(const std::string& name, const std::string& bytes, std::string* warnings = nullptr) {
  std::istringstream stream(bytes);
  std::string lines;
  PolygonMesh mesh = readMesh(stream, name, lines);
  if (warnings) *warnings = lines;
  else EXPECT_EQ(lines, "");
  return mesh;
}

/* The message for a file that must be rejected, or "". */
inline std::string meshError(const std::string& name, const std::string& bytes) {
  try {
    meshOf(name, bytes);
  } catch (const Error& e) {
    const std::string message = e.what();
    EXPECT_EQ(message.rfind(name, 0), 0u) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one line: " << message;
    return message;
  }
  return "";
}

using Corners = std::vector<unsigned>;

inline void expectPosition(const PolygonMesh& mesh, size_t i, double x, double y, double z) {
  ASSERT_LT(i, mesh.positions.size());
  EXPECT_NEAR(mesh.positions[i].x, x, 1e-12) << i;
  EXPECT_NEAR(mesh.positions[i].y, y, 1e-12) << i;
  EXPECT_NEAR(mesh.positions[i].z, z, 1e-12) << i;
}

} // namespace programs::test
