// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "picture_file.h"
#include "basics/error.h"
#include "pictures/exr_file.h"
#include "pictures/image_output.h"
#include "programs/outputs.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>

#include <filesystem>

namespace programs {
namespace {

bool isExr(const std::string& path) { return std::filesystem::path(path).extension() == ".exr"; }

void writeExr(const std::string& path, ImageSize size, const std::vector<Vec3f>& pixels) {
  static const char* const names[3] = {"R", "G", "B"};
  Imf::Header header(size.width, size.height);
  Imf::FrameBuffer frame;
  std::vector<Vec3f> copy = pixels; // OpenEXR's slices are not const
  for (size_t i = 0; i < 3; i++) {
    char* const first = reinterpret_cast<char*>(copy.data()) + i * sizeof(float);
    header.channels().insert(names[i], Imf::Channel(Imf::FLOAT));
    frame.insert(names[i], Imf::Slice(Imf::FLOAT, first, sizeof(Vec3f), sizeof(Vec3f) * size_t(size.width)));
  }
  writeExrFile(path, header, frame, size.height);
}

} // namespace

void validatePicturePath(const std::string& path) {
  if (!isExr(path) && std::filesystem::path(path).extension() != ".png")
    throw Error("invalid --output '" + path + "': expected a name that ends in .exr or .png");
  requireWritable({{"--output", path}});
}

Image toImage(ImageSize size, const std::vector<Vec3f>& pixels) {
  Image image(size);
  for (size_t i = 0; i < pixels.size(); i++) image.set(i, pixels[i]);
  return image;
}

void writePicture(const std::string& path, ImageSize size, const std::vector<Vec3f>& pixels) {
  if (isExr(path)) writeExr(path, size, pixels);
  else writePng(path, toImage(size, pixels));
}

} // namespace programs
