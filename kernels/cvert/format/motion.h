// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A block of cVERT that moves: a block as it is at its first time step, block.h, with all other steps behind it.
 *
 *   block of step 0, whose margins are of segment 0 | offsets of steps | step 1 | step 2 | ... | table of numbers
 *
 * A segment is the time between two steps; vertices and planes of boxes are linear in it. A step has its own lattice, origin and
 * corners, and cells as a block has them. A cell's residuals may be predicted from those that it has in step 0: what stands out from a
 * surface turns with it, so all residuals of the block are turned by one matrix, and only what that misses is stored.
 *
 *   step: VertStep | remainders' word | margins of the segment that begins | words of groups | fields of the first cell | fields of groups | remainders
 *
 * A raw step has its vertices as floats behind VertStep. Where one of its ends is raw, a segment has no margins that count, and its boxes
 * are those of the decoded vertices. */

#ifndef CVERT_VERT_MOTION_FORMAT_H
#define CVERT_VERT_MOTION_FORMAT_H

#include "block.h"

CVERT_BEGIN

CVERT_CONSTANT uint32_t maxTimeSteps = 129u;
CVERT_CONSTANT uint32_t vertStepBytes = 64u;
CVERT_CONSTANT uint32_t stepCornersOffset = 20u; //!< in a step

struct VertStep
{
  float origin[3];        //!< as of a block
  uint32_t boxForm;       //!< bits 0..23: of the segment that begins, as of a block, 3 in bits 12..13 where the step is raw; 24: has remainders; 25: the first cell is turned; 26: groups have upper bits of words; 27: has margins; 28..31: shift of reach
  uint32_t word;          //!< of the first cell, and the exponent of the spacing on x
  uint32_t corners[6];    //!< with the exponents on y and z, as of a block
  uint32_t turned;        //!< bits 0..15: groups whose residuals are turned; 16..18: the matrix's shift; 19..22: shift of endReach; 24..31: its last entry
  uint32_t turn[2];       //!< its other entries, a byte each, row by row: what x, y, z become
  uint32_t reach;         //!< bounds at this step, as of a block, in the shear of the segment that begins
  uint32_t endReach;      //!< the same in that of the segment that ends
};
CVERT_READABLE(VertStep,4)

/*! bounds of a block at an end of a segment are in steps of this */
CVERT_FUNCTION uint32_t beginReachStep (uint32_t boxForm) { return 1u << (boxForm >> 28); }
CVERT_FUNCTION uint32_t endReachStep (uint32_t turned) { return 1u << ((turned >> 19) & 15u); }

CVERT_FUNCTION bool isFirstCellTurned (uint32_t boxForm) { return ((boxForm >> 25) & 1u) != 0u; }
CVERT_FUNCTION bool hasUpperBits (uint32_t boxForm) { return ((boxForm >> 26) & 1u) != 0u; }
CVERT_FUNCTION bool hasMargins (uint32_t boxForm) { return ((boxForm >> 27) & 1u) != 0u; }
CVERT_FUNCTION bool isTurned (uint32_t turned, uint32_t g) { return ((turned >> g) & 1u) != 0u; }

/*! entries of the matrix are in units of 2^-this, 1 to 7 */
CVERT_FUNCTION uint32_t turnShift (uint32_t turned) { return 7u - ((turned >> 16) & 7u); }

/*! a byte of three words, signed */
CVERT_FUNCTION int turnEntry (uint32_t word, uint32_t byte) { return int(word << (24u - 8u*byte)) >> 24; }

/*! what a row of the matrix makes of a residual, rounded to the nearest, up where two are near */
CVERT_FUNCTION int turnedResidual (int a, int b, int c, int x, int y, int z, uint32_t shift) {
  return (a*x + b*y + c*z + (1 << (shift-1u))) >> shift;
}

/*! Whether a block is there at a time: from its first step to its last, both included. */
CVERT_FUNCTION bool isThere (VertMotion motion, float time) { return time >= motion.begin && time <= motion.end; }

/*! where a time is: behind which step, and how much of the way to the next, from 0 to 1, as Embree computes it */
struct TimeInMotion
{
  uint32_t segment;
  float fraction;
};

CVERT_FUNCTION TimeInMotion timeInMotion (VertMotion motion, float time)
{
  float steps = (time-motion.begin)/(motion.end-motion.begin)*float(motion.numSteps-1u);
  TimeInMotion at;
  at.segment = uint32_t(steps);
  if (at.segment > motion.numSteps-2u) at.segment = motion.numSteps-2u;
  at.fraction = steps - float(at.segment);
  return at;
}

/*! Bounds of a block between two steps. fraction: of the way from the first to the second */
CVERT_FUNCTION BlockReach reachBetween (BlockReach a, BlockReach b, float fraction)
{
  float e = 1.0f-fraction;
  BlockReach bounds;
  bounds.upper[0] = e*a.upper[0] + fraction*b.upper[0];
  bounds.upper[1] = e*a.upper[1] + fraction*b.upper[1];
  bounds.sheared[0] = e*a.sheared[0] + fraction*b.sheared[0];
  bounds.sheared[1] = e*a.sheared[1] + fraction*b.sheared[1];
  return bounds;
}

/*! What planes of boxes have to be moved by on an axis between two steps: vertices there are rounded by less than 3
 *  times 2^-24 of themselves, and so are origins and planes. a, b: origins at the steps on that axis; extent:
 *  extentOfReach, the larger of the two */
CVERT_FUNCTION float motionSlack (float a, float b, float extent) {
  return (greater(magnitude(a),magnitude(b)) + 2.0f*extent)*(1.0f/1048576.0f);
}

/*! offsets in bytes from the step's start */
struct VertStepLayout
{
  uint32_t remainders;         //!< the word of remainders, if it has any
  uint32_t margins, words, wordsHigh, cell;
  uint32_t vertices, rawBytes; //!< of a raw step
};

CVERT_FUNCTION VertStepLayout vertStepLayout (uint32_t region, uint32_t boxForm)
{
  uint32_t groups = groupsOf(vertQuadsX(region))*groupsOf(vertQuadsY(region));
  VertStepLayout offsets;
  offsets.remainders = vertStepBytes;
  offsets.margins = vertStepBytes + (hasRemainders(boxForm) ? vertRemaindersBytes : 0u);
  offsets.words = offsets.margins + (hasMargins(boxForm) ? (3u*groups + 1u) & ~1u : 0u);
  offsets.wordsHigh = offsets.words + 2u*groups;
  offsets.cell = offsets.wordsHigh + (hasUpperBits(boxForm) ? groups : 0u);
  offsets.vertices = vertStepBytes;
  offsets.rawBytes = offsets.vertices + 12u*(vertQuadsX(region)+1u)*(vertQuadsY(region)+1u);
  return offsets;
}

/*! entry of a step's matrix, row by row */
CVERT_FUNCTION int turnEntry (CVERT_IN(VertStep) step, uint32_t i) {
  return i < 8u ? turnEntry(step.turn[i >> 2],i & 3u) : turnEntry(step.turned,3u);
}

/*! step 1 and later */
CVERT_FUNCTION CVERT_POINTER(VertStep) stepOf (CVERT_POINTER(VertHeader) block, uint32_t step) {
  return CVERT_AS(VertStep,bytesAfter(block,wordAt(block,motionOf(block).steps/4u + step-1u)));
}

CVERT_END

#ifndef VULKAN
static_assert(sizeof(cvert::VertStep) == cvert::vertStepBytes
              && offsetof(cvert::VertStep,corners) == cvert::stepCornersOffset, "step of a block that moves");

CVERT_BEGIN

/*! bytes of a step, without those that fill it up */
inline uint32_t vertStepSize (const VertStep* step, uint32_t region)
{
  const VertStepLayout layout = vertStepLayout(region,step->boxForm);
  if (isRaw(step->boxForm)) return layout.rawBytes;
  if (hasRemainders(step->boxForm)) {
    const uint32_t remainders = wordAt(step,layout.remainders/4);
    return remainderOffset(remainders) + bytesOfRemainders(remainders,region);
  }
  return endOfFields(step,layout.cell,step->word,layout.words,
                     groupsOf(vertQuadsX(region))*groupsOf(vertQuadsY(region)));
}

/*! bytes of a block, without those that fill it up */
inline uint32_t vertBytes (const VertHeader* block)
{
  const uint32_t form = block->patchQuads;
  if (hasNumbers(block->boxForm) && haveTable(form)) {
    const VertNumbers numbers = numbersOf(block);
    const uint32_t entries = vertQuadsX(block->region)*vertQuadsY(block->region)*entriesPerQuad(form);
    return numbers.x + bytesOfNumberTable(entries,numbers.y);
  }
  if (hasNumbers(block->boxForm) && haveHalves(form)) return storedNumbersOf(block).x + uint32_t(sizeof(VertHalves));
  if (!isMoving(block->boxForm)) return vertFirstStepSize(block);
  const VertStep* last = stepOf(block,motionOf(block).numSteps-1);
  return uint32_t((const uint8_t*)last - (const uint8_t*)block) + vertStepSize(last,block->region);
}

CVERT_END
#endif

#endif
