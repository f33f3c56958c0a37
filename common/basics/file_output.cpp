// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/file_output.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace cbvh {

namespace fs = std::filesystem;

namespace {

/* Has the contents on disk before the name is: what a crash leaves is whole. */
void synchronise(const std::string& path)
{
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    return;
  fsync(file);
  close(file);
}

} // namespace

PendingFile::PendingFile(const std::string& path) : final(path)
{
  const fs::path p(path);
  temp = (p.parent_path() / (".tmp-" + std::to_string(getpid()) + "-" + p.stem().string() + p.extension().string()))
           .string();
  setUnfinishedFile(temp);
}

PendingFile::~PendingFile()
{
  setUnfinishedFile("");
  std::error_code ignored;
  if (!done)
    fs::remove(temp, ignored);
}

void PendingFile::commit()
{
  std::error_code code;
  fs::rename(temp, final, code);
  if (code)
    throw Error(final + ": cannot be written: " + code.message());
  done = true;
}

void writeTextFile(const std::string& path, const std::string& text)
{
  PendingFile file(path);
  std::ofstream stream(file.temporary(), std::ios::binary);
  stream << text;
  stream.close();
  if (!stream)
    throw Error(path + ": cannot be written");
  synchronise(file.temporary());
  file.commit();
}

void writeStandardOutput(const std::string& text)
{
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw Error(std::string("standard output cannot be written: ") + std::strerror(errno));
}

void prepareOutputFolder(const std::string& path)
{
  std::error_code code;
  fs::create_directories(path, code);
  if (code || !fs::is_directory(path, code))
    throw Error(path + ": cannot be made an output folder" + (code ? ": " + code.message() : ""));
  /* Asking for permissions lies on some file systems; a file does not. */
  PendingFile probe((fs::path(path) / "probe").string());
  std::ofstream stream(probe.temporary());
  if (!stream)
    throw Error(path + ": files cannot be written there");
}

} // namespace cbvh
