// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/outputs.h"
#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/input_files.h"

#include <filesystem>
#include <map>
#include <system_error>

namespace programs {
namespace {

namespace fs = std::filesystem;

/* Empty for devices and pipes, which outputs may share. */
std::string canonicalPath(const std::string& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (fs::exists(status) && !fs::is_regular_file(status)) return "";
  return fs::weakly_canonical(fs::absolute(path, code), code).string();
}

} // namespace

void validateOutputs(const SceneSettings& model, const std::vector<Output>& outputs) {
  for (const std::string& path : {model.cagePath, model.meshPath, model.savedPath, model.heightPath})
    recordInputFile(path);
  for (const std::string& path : model.cageEnds) recordInputFile(path);
  std::map<std::string, std::string> optionOf;
  for (const Output& output : outputs) {
    if (output.path.empty()) continue;
    try {
      requireNoInputFile(output.path);
    } catch (const Error& e) { throw Error(output.option + " " + e.what()); }
    const std::string canonical = canonicalPath(output.path);
    const auto [other, isNew] = optionOf.try_emplace(canonical, output.option);
    if (!isNew && !canonical.empty())
      throw Error(output.option + " " + output.path + ": " + other->second + " names the same file; expected another");
  }
}

void requireFolders(const std::vector<Output>& outputs) {
  for (const Output& output : outputs) {
    const fs::path folder = fs::path(output.path).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !fs::is_directory(folder, ignored))
      throw Error(output.option + " '" + output.path + "': there is no folder " + folder.string() +
                  ": expected an existing folder");
  }
}

void requireWritable(const std::vector<Output>& outputs) {
  requireFolders(outputs);
  for (const Output& output : outputs) try {
      if (!output.path.empty()) requireWritable(output.path);
    } catch (const Error& e) { throw Error(output.option + " " + e.what()); }
}

} // namespace programs
