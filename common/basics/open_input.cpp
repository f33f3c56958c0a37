// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/open_input.h"
#include "basics/error.h"
#include "basics/pipe_input.h"

#include <filesystem>
#include <fstream>
#include <system_error>

namespace programs {
namespace {

struct PipeStream : std::istream {
  explicit PipeStream(const std::string& path) : std::istream(nullptr), pipe(path) { rdbuf(&pipe); }
  PipeInput pipe;
};

} // namespace

std::unique_ptr<std::istream> openInput(const std::string& path) {
  if (isPipe(path)) return std::make_unique<PipeStream>(path);
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_character_file(status) || std::filesystem::is_block_file(status))
    throw Error(path + ": this is a device: expected a file or a pipe");
  auto stream = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*stream) throw Error(path + ": cannot be opened: expected a readable file");
  stream->peek(); // opening a directory succeeds, reading it fails
  if (stream->bad()) throw Error(path + ": cannot be read: expected a file, not a folder");
  stream->clear();
  return stream;
}

} // namespace programs
