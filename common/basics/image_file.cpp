// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/image_file.h"
#include "basics/error.h"
#include "basics/file_output.h"

#include <OpenImageIO/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace programs {
namespace {

/* Redirects OpenImageIO's writers into a PendingFile, because they ignore errors when they close a file. */
class PendingProxy : public OIIO::Filesystem::IOProxy {
public:
  PendingProxy(PendingFile& file, const std::string& path) : IOProxy(path, Write), file(file) {}

  const char* proxytype() const override { return "pending"; }
  size_t write(const void* data, size_t bytes) override {
    const size_t written = pwrite(data, bytes, m_pos);
    m_pos += int64_t(written);
    return written;
  }
  size_t pwrite(const void* data, size_t bytes, int64_t offset) override {
    if (!file.write(data, bytes, uint64_t(offset))) return 0;
    end = std::max(end, offset + int64_t(bytes));
    return bytes;
  }
  size_t size() const override { return size_t(end); }

private:
  PendingFile& file;
  int64_t end = 0;
};

/* OpenImageIO (2.4 to 3.1) writes the rows of FITS one too late, and sometimes the wrong last pixel of a row of RLA;
 * "null" and "term" write no file. */
constexpr const char* incorrectWriters[] = {"fits", "rla", "null", "term"};

std::unique_ptr<OIIO::ImageOutput> createOutput(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  auto output = OIIO::ImageOutput::create(extension.empty() ? "png" : extension.substr(1));
  if (!output) throw Error(path + ": cannot be written: " + OIIO::geterror());
  const std::string format = output->format_name();
  for (const char* name : incorrectWriters)
    if (format == name)
      throw Error(path + ": cannot be written: OpenImageIO does not write " + format +
                  " files correctly: expected another format, such as png or tif");
  return output;
}

} // namespace

void writeImageFile(const std::string& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels) {
  PendingFile file(path);
  PendingProxy proxy(file, path); // outlives the output, whose destructor may write
  const auto output = createOutput(path);
  if (output->supports("ioproxy")) output->set_ioproxy(&proxy);
  if (!output->open(file.temporary(), spec) || !output->write_image(type, pixels) || !output->close())
    throw Error(path + ": cannot be written: " + (file.error().empty() ? output->geterror() : file.error()));
  file.commit();
}

void requireImageFormat(const std::string& path) { createOutput(path); }

} // namespace programs
