// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/image_output.h"
#include "basics/image_file.h"
#include "pictures/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>

#include <cstdint>

namespace programs {

void writePng(const std::string& path, const Image& image) {
  const OIIO::ImageSpec spec(image.size.width, image.size.height, 3, OIIO::TypeDesc::UINT8);
  writeImageFile(path, spec, OIIO::TypeDesc::UINT8, image.rgb.data());
}

void writeExr(const std::string& path, ImageSize whole, const Crop& part, const std::vector<Vec3f>& colors,
              const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits) {
  constexpr int floats = 12;
  static const char* const names[floats] = {"P.X", "P.Y", "P.Z", "Z", "N.X", "N.Y", "N.Z", "u", "v", "R", "G", "B"};
  std::vector<float> values(hits.size() * floats, 0.0f);
  std::vector<unsigned> faces(hits.size());
  for (size_t i = 0; i < hits.size(); i++) {
    float* out = &values[i * floats];
    faces[i] = hits[i].face;
    out[3] = hits[i].t;
    out[9] = colors[i].x;
    out[10] = colors[i].y;
    out[11] = colors[i].z;
    if (!hits[i].hit()) continue;
    const Vec3f p = rays[i].origin + hits[i].t * rays[i].direction, n = normalize(hits[i].normal);
    out[0] = p.x;
    out[1] = p.y;
    out[2] = p.z;
    out[4] = n.x;
    out[5] = n.y;
    out[6] = n.z;
    out[7] = hits[i].u;
    out[8] = hits[i].v;
  }

  const ImageSize size = part.size();
  const Imath::Box2i display({0, 0}, {whole.width - 1, whole.height - 1});
  const Imath::Box2i data({part.x0, part.y0}, {part.x1 - 1, part.y1 - 1});
  Imf::Header header(display, data);
  /* OpenEXR expects the address of the whole picture's pixel (0,0), which may be outside of the array. */
  const auto origin = [&](void* first, size_t stride) {
    return reinterpret_cast<char*>(intptr_t(first) - (intptr_t(part.y0) * size.width + part.x0) * intptr_t(stride));
  };
  Imf::FrameBuffer frame;
  for (int i = 0; i < floats; i++) {
    header.channels().insert(names[i], Imf::Channel(Imf::FLOAT));
    frame.insert(names[i], Imf::Slice(Imf::FLOAT, origin(&values[i], sizeof(float) * floats), sizeof(float) * floats,
                                      sizeof(float) * floats * size_t(size.width)));
  }
  header.channels().insert("primID", Imf::Channel(Imf::UINT));
  frame.insert("primID", Imf::Slice(Imf::UINT, origin(faces.data(), sizeof(unsigned)), sizeof(unsigned),
                                    sizeof(unsigned) * size_t(size.width)));
  writeExrFile(path, header, frame, size.height);
}

} // namespace programs
