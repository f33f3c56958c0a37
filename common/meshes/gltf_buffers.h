// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The container of glTF 2.0: the JSON document, alone or in a GLB, and its buffers, which are in the GLB, in the
 * document as base64, or in other files. Images are not read. */

#include "meshes/gltf_value.h"
#include "meshes/input_bytes.h"

#include <nlohmann/json.hpp>

#include <map>
#include <string>

namespace programs {

/* Bytes of a buffer view. */
struct GltfBytes {
  const uint8_t* data = nullptr;
  uint64_t size = 0, stride = 0; // stride: between elements, or 0 if they follow each other
};

class GltfBuffers {
public:
  /* Reads the document. Throws Error for files of other versions and for required extensions that are not
   * supported. */
  explicit GltfBuffers(InputBytes& input);
  GltfBuffers(const GltfBuffers&) = delete;

  GltfValue document() const { return GltfValue(json, file); }

  /* Number of bytes of the file. */
  uint64_t fileSize() const { return bytesOfFile; }

  /* Valid as long as this object. Reads the buffer on first use. */
  GltfBytes view(size_t index);

private:
  void readGlb(InputBytes& input, std::string& text);
  void parse(const std::string& text);
  const std::string& buffer(size_t index);
  std::string load(const GltfValue& buffer, size_t index, uint64_t bytes);
  std::string loadFile(const GltfValue& place, const std::string& uri, uint64_t bytes) const;

  std::string file;
  nlohmann::json json;
  bool hasChunk = false;
  std::string chunk; // of a GLB
  std::map<size_t, std::string> loaded;
  uint64_t bytesOfFile = 0;
};

} // namespace programs
