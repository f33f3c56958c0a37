// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Writes compressed surfaces as OBJ, with the codec alone and without Embree.
//
// file_to_obj FILE.cbvh > FILE.obj

#include <cvert/decoder/decoded_block.h>
#include <cvert/decoder/decoded_mesh.h>
#include <cvert/file/file.h>
#include <cvert/file/tree_reader.h>

#include <cmath>
#include <cstdio>
#include <memory>

namespace {

bool isFinite(const float* p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

// Writes the quads of a block, except holes: quads with a vertex that is not finite. Returns the number of vertices so
// far.
unsigned writeBlock(const cvert::VertHeader* block, unsigned numVertices)
{
  const auto decoded = std::make_unique<cvert::DecodedBlock>(block); // first time step
  const unsigned width = decoded->quadsX + 1, height = decoded->quadsY + 1;
  for (unsigned i = 0; i < width*height; i++) {
    const float* p = decoded->vertices[i];
    if (isFinite(p))
      std::printf("v %.9g %.9g %.9g\n", p[0], p[1], p[2]);
    else
      std::printf("v 0 0 0\n");
  }
  for (unsigned y = 0; y < decoded->quadsY; y++)
    for (unsigned x = 0; x < decoded->quadsX; x++) {
      const unsigned corners[4] = {y*width + x, y*width + x + 1, (y + 1)*width + x + 1, (y + 1)*width + x};
      bool isFiniteQuad = true;
      for (unsigned corner : corners)
        isFiniteQuad &= isFinite(decoded->vertices[corner]);
      if (isFiniteQuad) {
        const unsigned first = numVertices + 1; // OBJ counts from 1
        std::printf("f %u %u %u %u\n", first + corners[0], first + corners[1], first + corners[2], first + corners[3]);
      }
    }
  return numVertices + width*height;
}

// Writes the triangles of a mesh block at its first time step. Returns the number of vertices so far.
unsigned writeMeshBlock(const cvert::MeshHeader* block, unsigned numVertices)
{
  const auto decoded = std::make_unique<cvert::DecodedMesh>(block);
  for (unsigned i = 0; i < decoded->numVertices; i++) {
    const float* p = decoded->vertices[i];
    std::printf("v %.9g %.9g %.9g\n", p[0], p[1], p[2]);
  }
  for (unsigned i = 0; i < decoded->numTriangles; i++) {
    const unsigned first = numVertices + 1; // OBJ counts from 1
    const auto& corners = decoded->triangles[i];
    std::printf("f %u %u %u\n", first + corners[0], first + corners[1], first + corners[2]);
  }
  return numVertices + decoded->numVertices;
}

} // namespace

int main(int argc, char** argv)
{
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FILE.cbvh > FILE.obj\n", argv[0]);
    return 2;
  }
  try {
    const cvert::File file(argv[1]);
    file.verify();
    unsigned numVertices = 0;
    for (size_t i = 0; i < file.size(); i++) {
      std::printf("o geometry%zu\n", i);
      cvert::forEachBlock(file.geometry(i), file.tree(i), [&](cvert::FileChild type, uint64_t offset) {
        if (type == cvert::FILE_FRAMED)
          throw cvert::Error(cvert::ErrorCode::UNSUPPORTED,
                             file.path + ": the file contains blocks of another representation: expected cVERT");
        const char* const block = file.blocks(i) + offset;
        numVertices = cvert::isMesh(type) ? writeMeshBlock((const cvert::MeshHeader*)block, numVertices)
                                          : writeBlock((const cvert::VertHeader*)block, numVertices);
      });
    }
  }
  catch (const cvert::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return std::fflush(stdout) == 0 && !std::ferror(stdout) ? 0 : 1;
}
