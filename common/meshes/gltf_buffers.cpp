// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/gltf_buffers.h"
#include "basics/input_files.h"
#include "basics/open_input.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

namespace programs {
namespace {

/* Extensions that do not change the geometry, by the beginning of their names, and those that are supported. */
constexpr const char* harmlessExtensions[] = {"KHR_mesh_quantization", "KHR_materials_", "KHR_texture_",
                                              "KHR_lights_",           "KHR_xmp",        "EXT_texture_",
                                              "EXT_lights_",           "MSFT_texture_"};

uint32_t littleEndian32(const uint8_t* bytes) {
  return uint32_t(bytes[0]) | uint32_t(bytes[1]) << 8 | uint32_t(bytes[2]) << 16 | uint32_t(bytes[3]) << 24;
}

/* Appends up to `bytes` bytes. Allocates only what the file has. */
void append(InputBytes& input, uint64_t bytes, std::string& text) {
  text.reserve(text.size() + input.capacityFor(bytes, 1));
  while (bytes > 0) {
    const size_t next = size_t(std::min<uint64_t>({bytes, input.require(1), uint64_t(1) << 20}));
    if (next == 0) return;
    text.append(reinterpret_cast<const char*>(input.data()), next);
    input.skip(next);
    bytes -= next;
  }
}

/* Returns false for text that is no base64. */
bool decodeBase64(std::string_view text, std::string& bytes) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0, count = 0;
  for (const char c : text) {
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+' || c == '-' ? 62
                      : c == '/' || c == '_' ? 63
                                             : -1;
    if (value < 0) return false;
    bits = bits << 6 | uint32_t(value);
    if ((count += 6) >= 8) bytes += char(bits >> (count -= 8) & 255);
  }
  return true;
}

/* Replaces %20 and the like. */
std::string decodeUri(const std::string& uri) {
  std::string path;
  for (size_t i = 0; i < uri.size(); i++) {
    if (uri[i] == '%' && i + 2 < uri.size() && std::isxdigit((unsigned char)uri[i + 1]) &&
        std::isxdigit((unsigned char)uri[i + 2])) {
      path += char(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else path += uri[i];
  }
  return path;
}

/* "https:" and the like; a single letter is a drive. */
bool hasScheme(const std::string& uri) {
  const size_t colon = uri.find(':');
  return colon != std::string::npos && colon > 1 &&
         std::all_of(uri.begin(), uri.begin() + ptrdiff_t(colon),
                     [](unsigned char c) { return std::isalnum(c) || c == '+' || c == '-' || c == '.'; });
}

} // namespace

GltfBuffers::GltfBuffers(InputBytes& input) : file(input.name()) {
  std::string text;
  if (input.require(4) >= 4 && std::equal(input.data(), input.data() + 4, "glTF")) readGlb(input, text);
  else append(input, ~uint64_t(0), text);
  bytesOfFile = input.offset();
  parse(text);
}

void GltfBuffers::readGlb(InputBytes& input, std::string& text) {
  const auto failAtEnd = [&] {
    input.fail("the file ends at byte " + std::to_string(input.offset() + input.require(0)) +
               ", within a chunk: expected a complete GLB");
  };
  if (input.require(12) < 12) failAtEnd();
  const uint32_t version = littleEndian32(input.data() + 4), length = littleEndian32(input.data() + 8);
  if (version != 2) input.fail("GLB of version " + std::to_string(version) + ": expected version 2");
  input.skip(12);
  for (size_t number = 0; input.offset() < length; number++) {
    if (input.require(8) < 8) failAtEnd();
    const uint32_t bytes = littleEndian32(input.data()), type = littleEndian32(input.data() + 4);
    if (number == 0 && type != 0x4E4F534A) input.fail("the first chunk is not JSON: expected a GLB of version 2");
    input.skip(8);
    const bool isBuffer = number == 1 && type == 0x004E4942;
    std::string other, &target = number == 0 ? text : isBuffer ? chunk : other;
    append(input, bytes, target);
    if (target.size() != bytes) failAtEnd();
    hasChunk |= isBuffer;
  }
  if (input.offset() != length || !input.atEnd())
    input.fail("the header states " + std::to_string(length) +
               " bytes, but the chunks or the file end elsewhere: expected a complete GLB");
}

void GltfBuffers::parse(const std::string& text) {
  try {
    json = nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& e) {
    throw Error(file + ": the document is invalid at byte " + std::to_string(e.byte) + ": expected JSON of glTF 2.0");
  } catch (const nlohmann::json::exception&) { throw Error(file + ": a number is too large: expected glTF 2.0"); }
  const GltfValue all = document();
  const std::string version = all.member("asset").member("version").text();
  const std::string least =
      all.member("asset").has("minVersion") ? all.member("asset").member("minVersion").text() : "";
  if (version.substr(0, 2) != "2." || !(least.empty() || least == "2.0"))
    throw Error(file + ": version " + quotedWord(least.empty() ? version : least) + ": expected glTF 2.0");
  for (size_t i = 0; i < all.count("extensionsRequired"); i++) {
    const std::string name = all.element("extensionsRequired", i).text();
    const bool isHarmless = std::any_of(std::begin(harmlessExtensions), std::end(harmlessExtensions),
                                        [&](const char* beginning) { return name.rfind(beginning, 0) == 0; });
    if (!isHarmless)
      throw Error(file + ": the file requires the extension " + quotedWord(name) +
                  ", which is not supported: expected a file without it, such as without compression");
  }
}

GltfBytes GltfBuffers::view(size_t index) {
  const GltfValue all = document(), view = all.element("bufferViews", index);
  const std::string& bytes = buffer(size_t(view.integer("buffer")));
  const uint64_t offset = view.integer("byteOffset", 0), size = view.integer("byteLength");
  if (offset > bytes.size() || size > bytes.size() - offset)
    view.fail("ends at byte " + std::to_string(offset) + " + " + std::to_string(size) + " of a buffer of " +
              std::to_string(bytes.size()) + " bytes");
  return {reinterpret_cast<const uint8_t*>(bytes.data()) + offset, size, view.integer("byteStride", 0)};
}

const std::string& GltfBuffers::buffer(size_t index) {
  const GltfValue buffer = document().element("buffers", index);
  const bool isChunk = index == 0 && hasChunk && !buffer.has("uri");
  const auto found = loaded.find(index);
  if (found != loaded.end()) return found->second;
  const uint64_t bytes = buffer.integer("byteLength");
  const std::string& all = isChunk ? chunk : (loaded[index] = load(buffer, index, bytes));
  if (all.size() < bytes)
    buffer.fail("has " + std::to_string(all.size()) + " bytes: expected " + std::to_string(bytes));
  return all;
}

std::string GltfBuffers::load(const GltfValue& buffer, size_t index, uint64_t bytes) {
  if (!buffer.has("uri")) buffer.fail(index == 0 ? "has no data" : "has no data, only 'fallback' of an extension");
  const std::string uri = buffer.member("uri").text();
  if (uri.rfind("data:", 0) != 0) return loadFile(buffer.member("uri"), uri, bytes);
  const size_t comma = uri.find(',');
  std::string decoded;
  if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos ||
      !decodeBase64(std::string_view(uri).substr(comma + 1), decoded))
    buffer.member("uri").fail("is invalid: expected base64");
  return decoded;
}

std::string GltfBuffers::loadFile(const GltfValue& place, const std::string& uri, uint64_t bytes) const {
  if (hasScheme(uri) || uri.find('\0') != std::string::npos)
    place.fail("is " + quotedWord(uri) + ": expected the path of a file, or base64");
  const std::string path = (std::filesystem::path(file).parent_path() / decodeUri(uri)).string();
  std::string content;
  try {
    const auto stream = openInput(path);
    InputBytes input(*stream, path);
    append(input, bytes, content);
  } catch (const Canceled&) { throw; } catch (const Error& e) {
    place.fail("refers to a file that cannot be read: " + std::string(e.what()));
  }
  recordInputFile(path);
  return content;
}

} // namespace programs
