// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/exr_file.h"
#include "basics/error.h"
#include "basics/file_output.h"

#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>

#include <exception>
#include <stdexcept>

namespace programs {
namespace {

/* Redirects OpenEXR into a PendingFile, because a destructor writes the last part and ignores errors. */
class PendingStream : public Imf::OStream {
public:
  PendingStream(PendingFile& file, const std::string& path) : OStream(path.c_str()), file(file) {}

  void write(const char data[], int bytes) override {
    if (!file.write(data, size_t(bytes), at)) throw std::runtime_error(file.error());
    at += uint64_t(bytes);
  }
  uint64_t tellp() override { return at; }
  void seekp(uint64_t position) override { at = position; }

private:
  PendingFile& file;
  uint64_t at = 0;
};

} // namespace

void writeExrFile(const std::string& path, const Imf::Header& header, const Imf::FrameBuffer& frame, int lines) {
  PendingFile file(path);
  try {
    PendingStream stream(file, path);
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(frame);
    output.writePixels(lines);
  } catch (const std::exception& e) {
    throw Error(path + ": cannot be written: " + (file.error().empty() ? e.what() : file.error()));
  }
  file.commit();
}

} // namespace programs
