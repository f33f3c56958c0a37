// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Writes compressed surfaces as OBJ, with the codec alone and without Embree. Of moving surfaces it writes the first
// time step.
//
// file_to_obj FILE.cbvh > FILE.obj

#include <cvert/decoder/decoded_block.h>
#include <cvert/decoder/decoded_mesh.h>
#include <cvert/file/file.h>
#include <cvert/file/tree_reader.h>

#include <cmath>
#include <cstdio>
#include <exception>

static bool isFinite(const float* p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

static void writeVertices(const float (*vertices)[3], unsigned count) {
  const float unused[3] = {0, 0, 0}; // OBJ has no NaN; no face uses the vertex
  for (unsigned i = 0; i < count; i++) {
    const float* p = isFinite(vertices[i]) ? vertices[i] : unused;
    std::printf("v %.9g %.9g %.9g\n", p[0], p[1], p[2]);
  }
}

// Writes a block of quads. first: number of its first vertex in the OBJ. Returns the first number for the next block.
static unsigned long long writeBlock(const cvert::VertHeader* block, unsigned long long first) {
  const cvert::DecodedBlock decoded(block);
  const unsigned width = decoded.quadsX + 1, height = decoded.quadsY + 1;
  writeVertices(decoded.vertices, width * height);
  for (unsigned y = 0; y < decoded.quadsY; y++)
    for (unsigned x = 0; x < decoded.quadsX; x++) {
      const unsigned long long i = first + y * width + x;
      if (isFinite(decoded.vertex(x, y)) && isFinite(decoded.vertex(x + 1, y)) && isFinite(decoded.vertex(x, y + 1)) &&
          isFinite(decoded.vertex(x + 1, y + 1))) // else it is a hole
        std::printf("f %llu %llu %llu %llu\n", i, i + 1, i + width + 1, i + width);
    }
  return first + width * height;
}

// The same for a block of triangles.
static unsigned long long writeMeshBlock(const cvert::MeshHeader* block, unsigned long long first) {
  const cvert::DecodedMesh decoded(block);
  writeVertices(decoded.vertices, decoded.numVertices);
  for (unsigned i = 0; i < decoded.numTriangles; i++) {
    const auto& corners = decoded.triangles[i];
    const unsigned long long a = first + corners[0], b = first + corners[1], c = first + corners[2];
    std::printf("f %llu %llu %llu\n", a, b, c);
  }
  return first + decoded.numVertices;
}

int main(int argc, char** argv) try {
  if (argc != 2) throw cvert::Error(cvert::ErrorCode::INVALID_ARGUMENT, "usage: file_to_obj FILE.cbvh > FILE.obj");
  const cvert::File file(argv[1]);
  file.verify();
  unsigned long long first = 1; // OBJ counts from 1
  for (size_t i = 0; i < file.size(); i++) {
    std::printf("o geometry%zu\n", i);
    cvert::forEachBlock(file.geometry(i), file.tree(i), [&](cvert::FileChild type, uint64_t offset) {
      const char* const block = file.blocks(i) + offset;
      if (type == cvert::FILE_FRAMED) file.failUnsupported(i, "it has blocks with frames: expected cVERT blocks");
      first = cvert::isMesh(type) ? writeMeshBlock((const cvert::MeshHeader*)block, first)
                                  : writeBlock((const cvert::VertHeader*)block, first);
    });
  }
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return 0;
  std::fprintf(stderr, "standard output cannot be written\n");
  return 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
