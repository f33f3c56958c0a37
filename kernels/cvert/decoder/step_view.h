// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A time step of a cVERT block: hides that first and later steps have different headers and offsets. */

#ifndef CVERT_DECODER_STEP_VIEW_H
#define CVERT_DECODER_STEP_VIEW_H

#include "../format/motion.h"

CVERT_BEGIN

struct StepView {
  CVERT_POINTER(uint8_t) data; //!< start of the block, or of a later step
  bool isLater;                //!< data points to a VertStep
  float origin[3];
  VertSpacing spacing;
  uint32_t info;        //!< VertHeader::info or VertStep::info
  uint32_t word;        //!< word of the first cell
  uint32_t rotation;    //!< VertStep::rotation; 0 at the first step
  uint32_t remainders;  //!< word of remainders; 0 if there are none
  bool storesUpperBits; //!< upper 8 bits of the words of groups; later steps may omit them
  uint32_t corners;     //!< offset of the words of corners, relative to data
  uint32_t margins, words, wordsHigh, cell, vertices; //!< relative to data, as in VertLayout
};

/*! Returns the step with `spacing` and `remainders` set. remainders: byte offset of the word of remainders. */
CVERT_INLINE StepView withSpacing(StepView step, uint32_t remainders) {
  uint32_t c = step.corners / 4u;
  step.spacing = vertSpacing(step.word, wordAt(step.data, c), wordAt(step.data, c + 1u), wordAt(step.data, c + 2u),
                             wordAt(step.data, c + 3u));
  step.remainders = hasRemainders(step.info) ? wordAt(step.data, remainders / 4u) : 0u;
  return step;
}

CVERT_INLINE StepView viewOfFirstStep(CVERT_POINTER(VertHeader) block, CVERT_IN(VertLayout) offsets) {
  StepView step;
  step.data = CVERT_AS(uint8_t, block);
  step.isLater = false;
  step.origin[0] = CVERT_AT(VertHeader, block).origin[0];
  step.origin[1] = CVERT_AT(VertHeader, block).origin[1];
  step.origin[2] = CVERT_AT(VertHeader, block).origin[2];
  step.info = CVERT_AT(VertHeader, block).info;
  step.word = CVERT_AT(VertHeader, block).word;
  step.rotation = 0u;
  step.storesUpperBits = true;
  step.corners = vertCornersOffset;
  step.margins = offsets.margins;
  step.words = offsets.words;
  step.wordsHigh = offsets.wordsHigh;
  step.cell = offsets.cell;
  step.vertices = offsets.vertices;
  return withSpacing(step, offsets.remainders);
}

/*! number: 1 to the number of steps minus 1. */
CVERT_INLINE StepView viewOfLaterStep(CVERT_POINTER(VertHeader) block, uint32_t region, uint32_t number) {
  CVERT_POINTER(VertStep) later = stepOf(block, number);
  StepView step;
  step.data = CVERT_AS(uint8_t, later);
  step.isLater = true;
  step.origin[0] = CVERT_AT(VertStep, later).origin[0];
  step.origin[1] = CVERT_AT(VertStep, later).origin[1];
  step.origin[2] = CVERT_AT(VertStep, later).origin[2];
  step.info = CVERT_AT(VertStep, later).info;
  step.word = CVERT_AT(VertStep, later).word;
  step.rotation = CVERT_AT(VertStep, later).rotation;
  step.storesUpperBits = laterStepStoresUpperBits(step.info);
  step.corners = stepCornersOffset;
  VertStepLayout offsets = vertStepLayout(region, step.info);
  step.margins = offsets.margins;
  step.words = offsets.words;
  step.wordsHigh = offsets.wordsHigh;
  step.cell = offsets.cell;
  step.vertices = offsets.vertices;
  return withSpacing(step, offsets.remainders);
}

/*! number: less than the number of steps; 0 unless the block moves. offsets: vertLayout of the block. */
CVERT_INLINE StepView viewOfStep(CVERT_POINTER(VertHeader) block, CVERT_IN(VertLayout) offsets, uint32_t number) {
  if (number == 0u) return viewOfFirstStep(block, offsets);
  return viewOfLaterStep(block, CVERT_AT(VertHeader, block).region, number);
}

CVERT_FUNCTION uint32_t cornerWord(CVERT_IN(StepView) step, int i) {
  return wordAt(step.data, step.corners / 4u + uint32_t(i));
}

CVERT_FUNCTION uint32_t wordOfGroup(CVERT_IN(StepView) step, uint32_t g) {
  return wordOfGroup(step.data, step.words, step.wordsHigh, step.storesUpperBits, g);
}

/*! Byte offset of the fields of group g, relative to data. */
CVERT_FUNCTION uint32_t fieldsOfGroup(CVERT_IN(StepView) step, uint32_t g) {
  return endOfFields(step.data, step.cell, step.word, step.words, g);
}

CVERT_FUNCTION bool isFirstCellRotated(CVERT_IN(StepView) step) {
  return step.isLater && isFirstCellRotated(step.info);
}
CVERT_FUNCTION bool isGroupRotated(CVERT_IN(StepView) step, uint32_t g) {
  return areResidualsRotated(step.rotation, g);
}

/* --- bounds in a segment between two steps that are not raw ------------------------------- */

/*! Bounds at the step in the shear of the segment that begins with it. */
CVERT_FUNCTION ShearedBounds boundsAtBegin(CVERT_IN(StepView) step) {
  uint32_t encoded = step.isLater ? CVERT_AT(VertStep, step.data).bounds : CVERT_AT(VertHeader, step.data).bounds;
  return decodeBounds(step.info, encoded, step.isLater ? beginBoundsUnit(step.info) : boundsUnit(step.info),
                      step.spacing);
}

/*! Bounds at the step in the shear of the segment that ends with it. info: of the step at the segment's begin. */
CVERT_FUNCTION ShearedBounds boundsAtEnd(CVERT_IN(StepView) step, uint32_t info) {
  return decodeBounds(info, CVERT_AT(VertStep, step.data).endBounds, endBoundsUnit(step.rotation), step.spacing);
}

CVERT_END

#endif
