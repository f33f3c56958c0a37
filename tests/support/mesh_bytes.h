// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Bytes of files of meshes, for tests and fuzz targets of readers. */

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace programs::test {

inline const std::string square[] = {"0 0 0", "1 0 0", "1 1 0", "0 1 0"};

template<typename T>
std::string bytesOf(T value, bool isBigEndian = false) {
  std::string bytes(sizeof(T), 0);
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (isBigEndian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template<typename T>
std::string bytesOf(const std::vector<T>& values, bool isBigEndian = false) {
  std::string bytes;
  for (const T value : values) bytes += bytesOf(value, isBigEndian);
  return bytes;
}

/* --- PLY ------------------------------------------------------------------------------- */

inline std::string plyHeader(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

/* A pentagon and a triangle of 6 vertices, with doubles, extra properties, lists and elements, faces first. */
inline std::string binaryPly(bool isBigEndian) {
  std::string text = plyHeader(isBigEndian ? "binary_big_endian" : "binary_little_endian",
                               "comment made by hand\nelement face 2\nproperty list uint8 uint16 vertex_index\n"
                               "property float32 quality\nelement range 1\nproperty list ushort int8 items\n"
                               "element vertex 6\nproperty uchar red\nproperty float64 z\nproperty list int float w\n"
                               "property double x\nproperty float y\n");
  const auto add = [&](auto value) { text += bytesOf(value, isBigEndian); };
  add(uint8_t(5));
  for (const uint16_t i : {0, 1, 2, 3, 4}) add(i);
  add(0.5f);
  add(uint8_t(3));
  for (const uint16_t i : {5, 4, 3}) add(i);
  add(0.25f);
  add(uint16_t(3));
  for (const int8_t i : {-1, 0, 1}) add(i);
  for (int i = 0; i < 6; i++) {
    add(uint8_t(200));
    add(double(i));
    add(int32_t(i));
    for (int k = 0; k < i; k++) add(float(k));
    add(1e6 + i * 1e-9);
    add(float(-i));
  }
  return text;
}

/* --- STL ------------------------------------------------------------------------------- */

/* Nine coordinates per triangle. */
inline std::string binaryStl(const std::vector<float>& coordinates, std::string header = "binary") {
  header.resize(80, ' ');
  std::string text = header + bytesOf(uint32_t(coordinates.size() / 9));
  for (size_t i = 0; i < coordinates.size(); i++) {
    if (i % 9 == 0) text += bytesOf(std::vector<float>{0, 0, 1});
    text += bytesOf(coordinates[i]);
    if (i % 9 == 8) text += bytesOf(uint16_t(7));
  }
  return text;
}

inline std::string stlFacet(const std::string& a, const std::string& b, const std::string& c) {
  return "facet normal 0 0 1\n outer loop\n  vertex " + a + "\n  vertex " + b + "\n  vertex " + c +
         "\n endloop\nendfacet\n";
}

/* --- glTF ------------------------------------------------------------------------------ */

inline std::string base64(const std::string& bytes) {
  const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](size_t k) { return i + k < bytes.size() ? uint32_t(uint8_t(bytes[i + k])) : 0; };
    const uint32_t bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (size_t k = 0; k < 4; k++) text += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
  }
  return text;
}

/* A document with one buffer. `accessors` and `views` are JSON objects separated by commas, `rest` are members, such
 * as meshes and nodes. */
inline std::string gltf(const std::string& buffer, const std::string& views, const std::string& accessors,
                        const std::string& rest, const std::string& uri = "") {
  const std::string data = uri.empty() ? "data:application/octet-stream;base64," + base64(buffer) : uri;
  return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" + std::to_string(buffer.size()) +
         (uri == "none" ? "" : R"(,"uri":")" + data + "\"") + R"(}],"bufferViews":[)" + views + R"(],"accessors":[)" +
         accessors + "]," + rest + "}";
}

inline std::string glb(std::string json, std::string buffer) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
  return "glTF" + bytesOf(uint32_t(2)) + bytesOf(uint32_t(28 + json.size() + buffer.size())) +
         bytesOf(uint32_t(json.size())) + "JSON" + json + bytesOf(uint32_t(buffer.size())) + std::string("BIN\0", 4) +
         buffer;
}

const std::string oneMesh = R"("nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0)";

/* The unit square as floats, and as unsigned shorts 0 1 2 3. */
inline std::string squareBuffer() {
  return bytesOf(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) +
         bytesOf(std::vector<uint16_t>{0, 1, 2, 0, 2, 3});
}
const std::string squareViews = R"({"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12})";
const std::string squareAccessors = R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
                                    R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"})";
const std::string squareMesh = R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)";

} // namespace programs::test
