#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Parts of a picture match the whole picture bit by bit, for static and moving models, in PNG and in OpenEXR, whose
# data window contains the position of a part.
#
# usage: render_crop.sh PATH/TO/cbvh_render PATH/TO/joined_parts

set -u
program=$1
join=$2
. "$(dirname -- "$0")/cli.sh"

picture=(--size 61x47 --samples 5 --exr) # multiples of neither tiles nor packets
crops=(0,0,30,20 30,0,61,20 0,20,30,47 30,20,61,47)

# render NAME OPTION...
render() {
  local name=$1
  shift
  "$program" "${picture[@]}" --output "$folder/$name" "$@" > "$folder/$name.txt" 2>&1 ||
    complain "$name: $(cat "$folder/$name.txt")"
}

scenes=(still moving)
options_still=(--scene cube)
options_moving=(--scene frog --motion twist --shutter 0.2,0.9)
for scene in "${scenes[@]}"; do
  declare -n options=options_$scene
  render "$scene" "${options[@]}"
  for crop in "${crops[@]}"; do
    render "$scene.$crop" "${options[@]}" --crop "$crop"
  done
  "$join" "$folder/$scene"/*.exr "$folder/$scene".*/*.exr || complain "$scene: parts differ from the whole picture"
done

# The same for a file, which many machines can share.
"$program" --scene cube --level 5 --size 64x64 --output "$folder/saved" --save "$folder/cube.cbvh" > /dev/null 2>&1 ||
  complain "--save"
render loaded --load "$folder/cube.cbvh"
for crop in "${crops[@]}"; do
  render "loaded.$crop" --load "$folder/cube.cbvh" --crop "$crop"
done
"$join" "$folder/loaded"/*.exr "$folder/loaded".*/*.exr ||
  complain "parts of a loaded file differ from the whole picture"

# --join restores all channels of the whole picture, and 8-bit pictures.
parts=()
for crop in 0,0,61,11 0,11,61,12 0,12,61,47; do
  render "rows.$crop" --scene cube --crop "$crop"
  parts+=("$folder/rows.$crop/cube_ctile")
done
"$program" --join "$folder/joined.exr" "${parts[@]/%/.exr}" || complain "--join of OpenEXR"
"$program" --size 61x47 --join "$folder/joined.png" "${parts[@]/%/.png}" || complain "--join of PNG"
"$join" "$folder/still/cube_ctile.exr" "$folder/joined.exr" || complain "the joined picture differs from the whole one"

expect_refusal "rows.0,12,.*: begins at row 12: expected row 11, after the part before" \
  --join "$folder/none.exr" "${parts[0]}.exr" "${parts[2]}.exr"
expect_refusal "rows.0,11,.*: begins at row 11: expected row 0" --join "$folder/none.exr" "${parts[1]}.exr"
expect_refusal "rows.0,11,.*: ends at row 12 of 47: expected all rows" \
  --join "$folder/none.exr" "${parts[0]}.exr" "${parts[1]}.exr"
expect_refusal "30 of 61 columns: expected whole rows" \
  --join "$folder/none.exr" "$folder/still.0,0,30,20/cube_ctile.exr"
expect_refusal "the parts have 61 x 12 pixels: expected 61 x 47" \
  --size 61x47 --join "$folder/none.png" "${parts[0]}.png" "${parts[1]}.png"
expect_refusal "cube_ctile.png: has other channels than the first part" \
  --join "$folder/none.exr" "${parts[0]}.exr" "${parts[1]}.png"
expect_refusal "join renders nothing: expected no --scene" \
  --scene cube --join "$folder/none.exr" "${parts[0]}.exr" "${parts[1]}.exr" "${parts[2]}.exr"
expect_refusal "missing.exr: cannot be read" --join "$folder/none.exr" "$folder/missing.exr"
expect_refusal "joined.png" --join "$folder/joined.png" "$folder/joined.png"
[ ! -e "$folder/none.exr" ] && [ ! -e "$folder/none.png" ] || complain "--join wrote a file"

for wrong in 0,0,30 0,0,30,20,1 0,0,30,x 0.5,0,30,20; do
  expect_refusal "crop '$wrong'.*x0,y0,x1,y1" --scene cube "${picture[@]}" --crop "$wrong" --output "$folder/none"
done
for empty in 30,0,30,20 30,0,20,20 0,20,30,19; do
  expect_refusal "crop '$empty'.*empty" --scene cube "${picture[@]}" --crop "$empty" --output "$folder/none"
done
for outside in 0,0,62,20 0,0,61,48 -1,0,30,20 61,0,62,1; do
  expect_refusal "crop '$outside'.*61x47" --scene cube "${picture[@]}" "--crop=$outside" --output "$folder/none"
done
expect_refusal "crop .*--speed" --scene cube "${picture[@]}" --crop 0,0,30,20 --compare --output "$folder/none"
[ -z "$(ls -A "$folder/none" 2> /dev/null)" ] || complain "files were written"

finish
