// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A moving block of cVERT: a block of the first time step (block.h), then all other steps. docs/formats/block.md
 * specifies it.
 *
 *   block of step 0, with margins of segment 0 | offsets of steps | step 1 | step 2 | ... | table of numbers
 *
 * Vertices and planes of boxes are linear in a segment, the time between two steps. Each step has its own lattice,
 * origin, corners and cells. Details rotate with the surface: one matrix per step rotates the residuals of step 0, and
 * cells may store only their difference from these predictions.
 *
 *   step: VertStep | word of remainders | margins of the segment that begins | words of groups |
 *         fields of the first cell | fields of groups | remainders
 *
 * A raw step stores its vertices as floats after VertStep. In a segment with a raw end, boxes are computed from decoded
 * vertices instead of margins. */

#ifndef CVERT_FORMAT_MOTION_H
#define CVERT_FORMAT_MOTION_H

#include "block.h"

CVERT_BEGIN

CVERT_CONSTANT uint32_t maxTimeSteps = 129u;
CVERT_CONSTANT uint32_t vertStepBytes = 64u;
CVERT_CONSTANT uint32_t stepCornersOffset = 20u; //!< offset of corners in a step

struct VertStep {
  float origin[3];     //!< as in VertHeader
  uint32_t info;       //!< bits 0..23: as in VertHeader, of the segment that begins; 3 in 12..13: the step is raw;
                       //!< 24: has remainders; 25: the first cell is rotated; 26: words of groups have upper bits;
                       //!< 27: has margins; 28..31: shift of bounds
  uint32_t word;       //!< of the first cell, and exponent of the spacing on x
  uint32_t corners[6]; //!< with the exponents on y and z, as in VertHeader
  uint32_t rotation;   //!< bits 0..15: groups whose residuals are rotated; 16..18: see rotationShift; 19..22:
                       //!< shift of endBounds; 23: reserved, 0; 24..31: last entry of the matrix
  uint32_t matrix[2];  //!< other entries of the matrix, a byte each, row by row
  uint32_t bounds;     //!< at this step, as in VertHeader, in the shear of the segment that begins
  uint32_t endBounds;  //!< at this step in the shear of the segment that ends
};
CVERT_READABLE(VertStep, 4)

/* Units of VertStep::bounds and VertStep::endBounds, see boundsUnit. */
CVERT_FUNCTION uint32_t beginBoundsUnit(uint32_t info) { return 1u << (info >> 28); }
CVERT_FUNCTION uint32_t endBoundsUnit(uint32_t rotation) { return 1u << ((rotation >> 19) & 15u); }

CVERT_FUNCTION bool isFirstCellRotated(uint32_t info) { return ((info >> 25) & 1u) != 0u; }
/*! Upper 8 bits of the words of groups, which the first step always stores. */
CVERT_FUNCTION bool laterStepStoresUpperBits(uint32_t info) { return ((info >> 26) & 1u) != 0u; }
CVERT_FUNCTION bool hasMargins(uint32_t info) { return ((info >> 27) & 1u) != 0u; }
CVERT_FUNCTION bool areResidualsRotated(uint32_t rotation, uint32_t g) { return ((rotation >> g) & 1u) != 0u; }

/*! Entries of the matrix are multiples of 2^-rotationShift. 1 to 7 in valid blocks. */
CVERT_FUNCTION uint32_t rotationShift(uint32_t rotation) { return 7u - ((rotation >> 16) & 7u); }

/*! Signed entry of the matrix in a byte of a word. */
CVERT_FUNCTION int rotationEntry(uint32_t word, uint32_t byte) { return int(word << (24u - 8u * byte)) >> 24; }

/*! Product of a row of the matrix and a residual. Rounds to nearest, halves up. */
CVERT_FUNCTION int rotatedResidual(int a, int b, int c, int x, int y, int z, uint32_t shift) {
  return (a * x + b * y + c * z + (1 << (shift - 1u))) >> shift;
}

/*! True from the first step to the last, inclusive. */
CVERT_FUNCTION bool isPresent(VertMotion motion, float time) { return time >= motion.begin && time <= motion.end; }

/*! A segment, and the position in it from 0 to 1. */
struct TimeInMotion {
  uint32_t segment;
  float fraction;
};

/*! Requires isPresent(motion,time). Rounds as Embree does. With two steps, the segment does not wait for divisions. If
 * time-begin and end-begin overflow, returns the end of the last segment. */
CVERT_FUNCTION TimeInMotion timeInMotion(VertMotion motion, float time) {
  float last = float(motion.numSteps - 1u);
  float steps = (time - motion.begin) / (motion.end - motion.begin) * last;
  if (!(steps < last)) steps = last; // steps is NaN after an overflow
  TimeInMotion at;
  at.segment = 0u;
  if (motion.numSteps > 2u) at.segment = uint32_t(steps);
  if (at.segment > motion.numSteps - 2u) at.segment = motion.numSteps - 2u;
  at.fraction = steps - float(at.segment);
  return at;
}

/*! fraction: 0 (a) to 1 (b). */
CVERT_FUNCTION ShearedBounds interpolateBounds(ShearedBounds a, ShearedBounds b, float fraction) {
  float e = 1.0f - fraction;
  ShearedBounds bounds;
  bounds.upper[0] = e * a.upper[0] + fraction * b.upper[0];
  bounds.upper[1] = e * a.upper[1] + fraction * b.upper[1];
  bounds.sheared[0] = e * a.sheared[0] + fraction * b.sheared[0];
  bounds.sheared[1] = e * a.sheared[1] + fraction * b.sheared[1];
  return bounds;
}

/*! Distance by which planes of boxes must move outwards on an axis between two steps: interpolated vertices, origins
 *  and planes are rounded by less than 3 times 2^-24 of their magnitude. The factor 2^-20 covers their sum. a, b:
 *  origins of the steps. extent: of both steps, see boxSlack (rule/rule.h). */
CVERT_FUNCTION float motionSlack(float a, float b, float extent) {
  return (maximum(magnitude(a), magnitude(b)) + 2.0f * extent) * (1.0f / 1048576.0f);
}

/*! Offsets of sections, in bytes from the start of the step. As in VertLayout. */
struct VertStepLayout {
  uint32_t remainders; //!< the word of remainders, if present
  uint32_t margins, words, wordsHigh, cell;
  uint32_t vertices, rawBytes; //!< offset of the vertices of a raw step, and size of the step
};

CVERT_FUNCTION VertStepLayout vertStepLayout(uint32_t region, uint32_t info) {
  uint32_t groups = groupsOf(vertQuadsX(region)) * groupsOf(vertQuadsY(region));
  VertStepLayout offsets;
  offsets.remainders = vertStepBytes;
  offsets.margins = vertStepBytes + (hasRemainders(info) ? vertRemaindersBytes : 0u);
  offsets.words = offsets.margins + (hasMargins(info) ? (3u * groups + 1u) & ~1u : 0u);
  offsets.wordsHigh = offsets.words + 2u * groups;
  offsets.cell = offsets.wordsHigh + (laterStepStoresUpperBits(info) ? groups : 0u);
  offsets.vertices = vertStepBytes;
  offsets.rawBytes = offsets.vertices + 12u * (vertQuadsX(region) + 1u) * (vertQuadsY(region) + 1u);
  return offsets;
}

/*! Entry i of the matrix, row by row. */
CVERT_FUNCTION int rotationEntry(CVERT_IN(VertStep) step, uint32_t i) {
  return i < 8u ? rotationEntry(step.matrix[i >> 2], i & 3u) : rotationEntry(step.rotation, 3u);
}

/*! Requires step >= 1. */
CVERT_FUNCTION CVERT_POINTER(VertStep) stepOf(CVERT_POINTER(VertHeader) block, uint32_t step) {
  return CVERT_AS(VertStep, bytesAfter(block, wordAt(block, motionOf(block).steps / 4u + step - 1u)));
}

CVERT_END

#ifndef VULKAN
static_assert(sizeof(cvert::VertStep) == cvert::vertStepBytes &&
                  offsetof(cvert::VertStep, corners) == cvert::stepCornersOffset,
              "step of a block that moves");

CVERT_BEGIN

/*! Size of a later step in bytes, without padding. */
inline uint32_t vertStepSize(const VertStep* step, uint32_t region) {
  const VertStepLayout layout = vertStepLayout(region, step->info);
  if (isRaw(step->info)) return layout.rawBytes;
  if (hasRemainders(step->info)) {
    const uint32_t remainders = wordAt(step, layout.remainders / 4);
    return remainderOffset(remainders) + bytesOfRemainders(remainders, region);
  }
  return endOfFields(step, layout.cell, step->word, layout.words,
                     groupsOf(vertQuadsX(region)) * groupsOf(vertQuadsY(region)));
}

/*! End of the last step of a valid block, in bytes from the start of the block. */
inline uint32_t endOfSteps(const VertHeader* block) {
  if (!isMoving(block->info)) return vertFirstStepSize(block);
  const VertStep* last = stepOf(block, motionOf(block).numSteps - 1);
  return uint32_t((const uint8_t*)last - (const uint8_t*)block) + vertStepSize(last, block->region);
}

/*! Size of a valid block in bytes, with all steps and the table of numbers, without padding. */
inline uint32_t vertBytes(const VertHeader* block) {
  if (const uint32_t end = endOfNumbers(block, 0)) return end;
  return endOfSteps(block);
}

CVERT_END
#endif

#endif
