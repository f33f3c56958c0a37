// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A block of cVERT: up to 16 x 16 quads whose vertices lie on a lattice of the world, in up to
 * 4 x 4 groups of 4 x 4 quads. It is
 *
 *   header | margins of groups | words of groups | fields of the first cell | fields of groups
 *
 * The lattice is the multiples of the spacing, a power of two, on all three axes. Vertices are
 * stored relative to the block's lowest lattice point and are exact floats in the world: a
 * vertex that blocks share is the same three floats in each, so that surfaces are closed as
 * the triangles are. There is no frame. A group's box is that of its four corners, which the first
 * cell has, grown by margins of 4 bits a side. It lies between planes of two of the world's axes and those of a third that is sheared along the block: a sheet
 * that is inclined has flat boxes, without a frame.
 *
 * A raw block stores its vertices and boxes as floats in place of all that: where one of them is
 * not finite, or too far from the others for the lattice's integers.
 *
 * Only layout lives here; vertex_cell.h gives words and fields their meaning. */

#ifndef CBVH_VERT_BLOCK_H
#define CBVH_VERT_BLOCK_H

#include "cell.h"

CBVH_BEGIN

/*! of the bytes described here; a change that readers have to know of counts up */
CBVH_CONSTANT uint32_t vertFormatVersion = 2u;

CBVH_CONSTANT uint32_t groupQuads = 4u;         //!< along a side of a group
CBVH_CONSTANT uint32_t maxVertHeight = 4u;      //!< blocks have at most 2^this quads along a side
CBVH_CONSTANT uint32_t maxVertGroups = 16u;
CBVH_CONSTANT uint32_t vertHeaderBytes = 64u;
CBVH_CONSTANT uint32_t maxMargin = 15u;         //!< in steps
CBVH_CONSTANT uint32_t boxPlanes = 6u;          //!< of a raw block: x, y, z lower, then x, y, z upper

struct VertHeader
{
  float origin[3];        //!< world position of the block's lowest lattice point
  uint32_t reach;         //!< bounds of the block, 8 bits each: see reachStep
  uint32_t geomID;
  uint32_t primID;
  uint32_t place;         //!< size, position and sub-patch: see the accessors
  uint32_t rates;         //!< of the patch's four edges, less 1, 8 bits each
  uint32_t corners[6];    //!< coordinates of the corners 00, 10, 01, 11, 16 bits each: x, y, z of 00 first
  uint32_t boxForm;       //!< bits 0..11: shifts of margins, 12..23: shear of boxes, 25..28: shift of reach, see below; 24: raw
  uint32_t word;          //!< of the first cell; bits 24..31: exponent of the lattice's spacing
};

CBVH_FUNCTION uint32_t vertPlace (uint32_t quadsX, uint32_t quadsY, uint32_t x, uint32_t y, uint32_t cornerU, uint32_t cornerV) {
  return (quadsX-1u) | ((quadsY-1u) << 4) | (x << 8) | (y << 16) | (cornerU << 24) | (cornerV << 28);
}
CBVH_FUNCTION uint32_t vertQuadsX (uint32_t place) { return (place & 15u) + 1u; }
CBVH_FUNCTION uint32_t vertQuadsY (uint32_t place) { return ((place >> 4) & 15u) + 1u; }
CBVH_FUNCTION uint32_t vertX (uint32_t place) { return (place >> 8) & 255u; }        //!< first quad in the patch
CBVH_FUNCTION uint32_t vertY (uint32_t place) { return (place >> 16) & 255u; }
CBVH_FUNCTION uint32_t vertCornerU (uint32_t place) { return (place >> 24) & 15u; }  //!< face parameter of the patch's corner, in halves
CBVH_FUNCTION uint32_t vertCornerV (uint32_t place) { return place >> 28; }

/*! of edge 0 (v = 0), 1 (u = 1), 2 (v = 1) or 3 (u = 0) of the patch */
CBVH_FUNCTION uint32_t vertRate (uint32_t rates, int edge) { return ((rates >> (8*edge)) & 255u) + 1u; }
CBVH_FUNCTION uint32_t greaterRate (uint32_t a, uint32_t b) { return a > b ? a : b; }
CBVH_FUNCTION uint32_t patchQuadsX (uint32_t rates) { return greaterRate(vertRate(rates,0),vertRate(rates,2)); }
CBVH_FUNCTION uint32_t patchQuadsY (uint32_t rates) { return greaterRate(vertRate(rates,1),vertRate(rates,3)); }

CBVH_FUNCTION uint32_t groupsOf (uint32_t quads) { return (quads + groupQuads-1u)/groupQuads; }

/*! quads along a side of group g of a row */
CBVH_FUNCTION uint32_t quadsOfGroup (uint32_t quads, uint32_t g)
{
  uint32_t rest = quads - groupQuads*g;
  return rest < groupQuads ? rest : groupQuads;
}

/* Boxes have planes on two axes of the world, and on a third, m, of the sheared coordinate
 *
 *   h = c[m] + (s1 c[m+1] + s2 c[m+2])/16,    axes counted round,
 *
 * which is the same all over a plane of the block's slope. Shifts, axis and slopes are where a
 * cell's word has bits, main axis and slopes; slopes of 0 make boxes of the world's axes. */

/*! a step of margins on an axis is 2^this */
CBVH_FUNCTION uint32_t marginShift (uint32_t boxForm, int axis) { return (boxForm >> (4*axis)) & 15u; }

CBVH_FUNCTION int shearedAxis (uint32_t boxForm) { return cellAxis(boxForm,0); }

/*! in 1/16, of the next axis (i = 1) and the one after it (i = 2) */
CBVH_FUNCTION int shearSlope (uint32_t boxForm, int i) { return cellSlope(boxForm,i); }

/*! Bounds of the block, in coordinates, are steps of this: bits 0..7 and 8..15 of its reach are those
 *  on the axes m+1 and m+2, where it begins at 0; 16..23 and 24..31, signed, the sheared coordinates
 *  that it lies between. */
CBVH_FUNCTION uint32_t reachStep (uint32_t boxForm) { return 1u << ((boxForm >> 25) & 15u); }
CBVH_FUNCTION int reachOf (uint32_t reach, int i)
{
  int bits = int((reach >> (8*i)) & 255u);
  return i >= 2 && bits >= 128 ? bits-256 : bits;
}

/*! spacing of the lattice: a power of two, whose exponent the word of the first cell has as a float has it */
CBVH_FUNCTION float vertSpacing (uint32_t word) { return floatOfBits((word >> 24) << 23); }

CBVH_FUNCTION bool isRaw (uint32_t boxForm) { return ((boxForm >> 24) & 1u) != 0u; }

/*! margins of a group on an axis, in coordinates, from their byte */
CBVH_FUNCTION int lowerMargin (uint32_t margins, uint32_t shift) { return int((margins & 15u) << shift); }
CBVH_FUNCTION int upperMargin (uint32_t margins, uint32_t shift) { return int((margins >> 4) << shift); }

/*! Corner c (column + 2 row) of the block: its coordinate along an axis. pair: the word of
 *  corners that has it, cornerPair(c,axis). */
CBVH_FUNCTION int cornerPair (int c, int axis) { return (3*c + axis) >> 1; }
CBVH_FUNCTION int cornerCoordinate (uint32_t pair, int c, int axis) { return int((pair >> (16*((3*c + axis) & 1))) & 65535u); }

/*! offsets in bytes from the block's start; group g is row by row */
struct VertLayout
{
  uint32_t groupsX, groupsY, groups;
  uint32_t margins;   //!< axis by axis, a byte a group: lower, then upper bits
  uint32_t words;     //!< lower 16 bits of each group's word
  uint32_t wordsHigh; //!< upper 8 bits
  uint32_t cell;      //!< fields of the first cell
  /* of a raw block */
  uint32_t vertices;  //!< x, y, z of each, row by row
  uint32_t boxes;     //!< plane by plane, a float a group
  uint32_t rawBytes;
};

CBVH_FUNCTION VertLayout vertLayout (uint32_t place)
{
  VertLayout offsets;
  offsets.groupsX = groupsOf(vertQuadsX(place));
  offsets.groupsY = groupsOf(vertQuadsY(place));
  offsets.groups = offsets.groupsX*offsets.groupsY;
  offsets.margins = vertHeaderBytes;
  offsets.words = offsets.margins + ((3u*offsets.groups + 1u) & ~1u);
  offsets.wordsHigh = offsets.words + 2u*offsets.groups;
  offsets.cell = offsets.wordsHigh + offsets.groups;
  offsets.vertices = vertHeaderBytes;
  offsets.boxes = offsets.vertices + 12u*(vertQuadsX(place)+1u)*(vertQuadsY(place)+1u);
  offsets.rawBytes = offsets.boxes + 4u*boxPlanes*offsets.groups;
  return offsets;
}

/*! Where Embree's stitching puts vertex x of an edge of the grid whose own rate is lower. */
CBVH_FUNCTION uint32_t stitchedVertex (uint32_t x, uint32_t quads, uint32_t rate) { return (2u*x + 1u)*rate/(2u*quads); }

/*! Parameter of the patch at vertex x of a row (column) of quads quads: that of GRID's
 *  vertex. rate: of the edge that the row lies on, or quads inside of the patch. */
CBVH_REAL CBVH_FUNCTION Real vertParameter (uint32_t x, uint32_t quads, uint32_t rate) {
  return Real(float(stitchedVertex(x,quads,rate)))/Real(float(rate));
}

CBVH_END

#ifndef VULKAN
#include <cstddef>
static_assert(sizeof(embree::cbvh::VertHeader) == embree::cbvh::vertHeaderBytes, "header of a block of cVERT");
#endif

#endif
