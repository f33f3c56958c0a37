// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Encodes a grid with the codec alone, decodes it, and writes a file that Embree CBVH can trace.
//
// encode_grid FILE.cbvh

#include <cvert/decoder/decoded_block.h>
#include <cvert/encoder/block_encoder.h>
#include <cvert/encoder/lattice.h>
#include <cvert/file/writer.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

namespace {

const unsigned quads = 64;              // per side of the grid
const unsigned side = cvert::vertBlockQuads;
const cvert::WorldLattice lattice(-10); // rounds vertices to multiples of 1/1024

void vertexOf(unsigned x, unsigned y, float* p)
{
  const float at[3] = {float(x), float(y), 3*std::sin(0.2f*float(x))*std::cos(0.15f*float(y))};
  for (int k = 0; k < 3; k++)
    p[k] = lattice.snap(at[k]);
}

// Encodes the block at quad (x,y) and appends it to the surface, which refers to `block`. Returns its bytes, or 0 if
// the decoded vertices differ.
size_t encodeBlock(unsigned x, unsigned y, std::vector<uint64_t>& block, cvert::FileSurface& surface)
{
  const auto encoder = std::make_unique<cvert::VertEncoder>();
  for (unsigned j = 0; j <= side; j++)
    for (unsigned i = 0; i <= side; i++)
      vertexOf(x + i, y + j, encoder->vertices[j*(side + 1) + i]);
  std::vector<std::vector<float>> given;
  for (unsigned i = 0; i < (side + 1)*(side + 1); i++)
    given.emplace_back(encoder->vertices[i], encoder->vertices[i] + 3);

  block.resize(cvert::VertEncoder::maxBytes/8 + 1);
  cvert::VertStatistics statistics;
  const cvert::VertPlacement place(cvert::vertRegion(side, side, x, y), cvert::vertPatch(quads, quads));
  const size_t bytes = encoder->encode(place, (uint8_t*)block.data(), statistics);
  surface.appendToList(block.data(), uint32_t(bytes));

  const auto decoded = std::make_unique<cvert::DecodedBlock>((const cvert::VertHeader*)block.data());
  for (unsigned i = 0; i < given.size(); i++)
    if (std::memcmp(decoded->vertices[i], given[i].data(), 3*sizeof(float)) != 0)
      return 0;
  return bytes;
}

} // namespace

int main(int argc, char** argv)
{
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FILE.cbvh\n", argv[0]);
    return 2;
  }
  try {
    cvert::FileSurface surface;
    surface.record.form = cvert::FILE_LIST;
    surface.record.source = cvert::FILE_GRIDS;
    surface.record.compression = cvert::FILE_COMPRESSION_VERT;
    surface.record.numPrimitives = 1;
    surface.record.numTimeSteps = 1;
    std::vector<std::vector<uint64_t>> blocks((quads/side)*(quads/side)); // needed until the surface is written
    size_t total = 0;
    for (unsigned i = 0; i < blocks.size(); i++) {
      const size_t bytes = encodeBlock(side*(i % (quads/side)), side*(i/(quads/side)), blocks[i], surface);
      if (bytes == 0) {
        std::fprintf(stderr, "block %u: the decoded vertices differ from the encoded ones\n", i);
        return 1;
      }
      total += bytes;
    }
    cvert::FileWriter writer(argv[1]);
    writer.add(surface);
    writer.commit();
    std::printf("%.2f bytes per quad, all decoded vertices are identical\n", double(total)/(quads*quads));
  }
  catch (const cvert::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
