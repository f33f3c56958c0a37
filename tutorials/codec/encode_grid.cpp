// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Encodes a grid with the codec alone, decodes it, and writes a file that Embree CBVH can trace:
// encode_grid FILE.cbvh

#include <cvert/decoder/decoded_block.h>
#include <cvert/encoder/block_encoder.h>
#include <cvert/encoder/lattice.h>
#include <cvert/file/writer.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <vector>

static const unsigned quads = 64; // per side of the grid
static const unsigned side = cvert::vertBlockQuads;
static const cvert::WorldLattice lattice(-10); // rounds vertices to multiples of 1/1024

static void vertexOf(unsigned x, unsigned y, float* p) {
  p[0] = lattice.snap(float(x));
  p[1] = lattice.snap(float(y));
  p[2] = lattice.snap(3 * std::sin(0.2f * float(x)) * std::cos(0.15f * float(y)));
}

// Encodes the block at quad (x,y). Returns its bytes.
static size_t encodeBlock(unsigned x, unsigned y, void* block) {
  const auto encoder = std::make_unique<cvert::VertEncoder>();
  for (unsigned j = 0; j <= side; j++)
    for (unsigned i = 0; i <= side; i++) vertexOf(x + i, y + j, encoder->vertices[j * (side + 1) + i]);
  const cvert::VertPlacement placement(cvert::packRegion(side, side, x, y), cvert::packPatchQuads(quads, quads));
  cvert::VertStatistics statistics;
  return encoder->encode(placement, (uint8_t*)block, statistics);
}

// Returns true if the vertices of the block at quad (x,y) are decoded to the same floats.
static bool isExact(unsigned x, unsigned y, const void* block) {
  const cvert::DecodedBlock decoded((const cvert::VertHeader*)block);
  float p[3];
  for (unsigned j = 0; j <= side; j++)
    for (unsigned i = 0; i <= side; i++) {
      vertexOf(x + i, y + j, p);
      if (std::memcmp(decoded.vertex(i, j), p, sizeof(p)) != 0) return false;
    }
  return true;
}

int main(int argc, char** argv) try {
  if (argc != 2) throw cvert::Error(cvert::ErrorCode::INVALID_ARGUMENT, "usage: encode_grid FILE.cbvh");
  cvert::FileSurface surface;
  surface.record.form = cvert::FILE_LIST;
  surface.record.source = cvert::FILE_GRIDS;
  surface.record.compression = cvert::FILE_COMPRESSION_VERT;
  surface.record.numPrimitives = surface.record.numTimeSteps = 1;
  std::vector<std::vector<uint64_t>> blocks; // the surface refers to them until it is written
  size_t total = 0;
  for (unsigned y = 0; y < quads; y += side)
    for (unsigned x = 0; x < quads; x += side) {
      blocks.emplace_back(cvert::VertEncoder::maxBytes / 8 + 1);
      const size_t bytes = encodeBlock(x, y, blocks.back().data());
      if (!isExact(x, y, blocks.back().data())) throw cvert::Error(cvert::ErrorCode::DAMAGED, "a vertex differs");
      surface.appendToList(blocks.back().data(), uint32_t(bytes));
      total += bytes;
    }
  cvert::FileWriter writer(argv[1]);
  writer.add(surface);
  writer.commit();
  std::printf("%.2f bytes per quad, all decoded vertices are identical\n", double(total) / (quads * quads));
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
