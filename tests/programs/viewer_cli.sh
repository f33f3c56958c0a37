#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests cbvh_viewer without a display: its pictures, and for invalid input one clear line, a nonzero exit status and no
# output file. render_cli.sh tests options that the programs share.
#
# usage: viewer_cli.sh PATH/TO/cbvh_viewer PATH/TO/cbvh_render

set -u
program=$1
render=$2
. "$(dirname -- "$0")/cli.sh"
unset DISPLAY WAYLAND_DISPLAY

# refuses PATTERN ARGUMENT...
refuses() {
  local pattern=$1
  shift
  rm -f "$folder/out.png"
  [[ "$*" == *--output* ]] || set -- "$@" --output "$folder/out.png"
  expect_refusal "$pattern" --no-window "$@"
  [ ! -e "$folder/out.png" ] || complain "a file was written: $*"
}

refuses "scene 'teapot'.*cube, frog" --scene teapot
refuses "scene .*--cage .*--mesh " --level 2
refuses "missing.obj: " --cage "$folder/missing.obj"
refuses "$folder/missing.obj: " "$folder/missing.obj"
refuses "quad.obj.*other.obj.*one cage" "$folder/quad.obj" "$folder/other.obj"
refuses "heights.png: .*cage" "$folder/heights.png"
refuses "$folder/missing.cbvh: " "$folder/missing.cbvh"
refuses "quad.cbvh: .*alone.*one file" "$folder/quad.obj" "$folder/quad.cbvh"
refuses "quad.cbvh: .*alone.*model" --scene cube "$folder/quad.cbvh"
echo "no surfaces" > "$folder/text.cbvh"
refuses "invalid argument: .*text.cbvh: .* 12 bytes" "$folder/text.cbvh"
refuses "text.cbvh: .*--level" "$folder/text.cbvh" --level 3
refuses "show blocks .*$folder/text.cbvh .*shading.*normals" "$folder/text.cbvh" --show blocks
refuses "quad.obj: --scene .*--cage " --scene cube "$folder/quad.obj"
refuses "heights.png: --height " "$folder/quad.obj" "$folder/heights.png" \
  --height "$folder/heights.png"
refuses "representation 'grid,cleaf,cvoxel' .*two" --scene cube --representation grid,cleaf,cvoxel
refuses "show 'pretty'.*shading" --scene cube --show pretty
refuses "threads -1 " --scene cube --threads -1
refuses "time 2.* 0 to 1" --scene cube --motion turn --time 2
refuses "time nan.* 0 to 1" --scene cube --motion turn --time nan
refuses "option --paint" --scene cube --paint red
refuses "output '$folder/missing/out.png': .*$folder/missing" --scene cube --level 2 --output "$folder/missing/out.png"
refuses "$folder/out.txt: .*txt" --scene cube --level 2 --output "$folder/out.txt"

"$program" --scene cube --level 2 > /dev/null 2> "$folder/stderr"
status=$?
[ $status = 1 ] || complain "exit status $status without a display"
grep -q "^cbvh_viewer: .*window.*--no-window" "$folder/stderr" || complain "without a display: $(cat "$folder/stderr")"

for mode in shading normals error cells blocks; do
  for representation in naive naive-compact grid cgrid,cvoxel cleaf^auto,cvoxel^8; do
    "$program" --scene cube --level 3 --size 65x47 --show $mode --representation $representation \
      --no-window --output "$folder/$mode-${representation//,/-}.ppm" 2> "$folder/stderr" ||
      complain "$mode, $representation: $(cat "$folder/stderr")"
    [ "$(head -c 12 "$folder/$mode-${representation//,/-}.ppm" | tr '\n' ' ')" = "P6 65 47 255" ] ||
      complain "$mode, $representation: no picture of 65 x 47"
  done
done
# A file shows the same picture as its scene, also in motion, and a window would open it.
"$render" --scene cube --level 3 --motion turn --representation cvert --size 65x47 --output "$folder/saved" \
  --save "$folder/cube.cbvh" > /dev/null 2>&1 || complain "cube.cbvh is not written"
for mode in shading normals; do
  for view in "full --time 0.5" "3,2,4,0,0,0,40"; do
    "$program" --scene cube --level 3 --motion turn --size 65x47 --show $mode --view $view \
      --no-window --output "$folder/built.ppm" 2> "$folder/stderr" || complain "built: $(cat "$folder/stderr")"
    "$program" "$folder/cube.cbvh" --size 65x47 --show $mode --view $view --no-window \
      --output "$folder/opened.ppm" 2> "$folder/stderr" || complain "opened: $(cat "$folder/stderr")"
    [ "$view" = "full --time 0.5" ] || cmp "$folder/built.ppm" "$folder/opened.ppm" ||
      complain "a different picture from a file, $mode"
    [ "$(tail -c $((65 * 47 * 3)) "$folder/opened.ppm" | od -An -v -tu1 -w3 | sort -u | wc -l)" -gt 50 ] ||
      complain "empty picture of a file, $mode, $view"
  done
done

# Generated maps are stored in the user's cache, not in the working directory.
mkdir "$folder/work"
(cd "$folder/work" &&
  "$program" --scene trex --mapping atlas --level 0 --size 64x64 --no-window --output "$folder/trex.ppm" \
    2> "$folder/stderr") ||
  complain "trex: $(cat "$folder/stderr")"
[ -s "$folder/cache/embree-cbvh/trex_height_atlas.exr" ] ||
  complain "no map in the user's cache: $(ls -R "$folder/cache")"
[ -z "$(ls -A "$folder/work")" ] || complain "left in the working directory: $(ls -A "$folder/work")"
"$program" --scene trex --mapping atlas --level 0 --size 64x64 --no-window --output "$folder/again.ppm" \
  2> "$folder/stderr"
cmp "$folder/trex.ppm" "$folder/again.ppm" || complain "a different picture with the map from the cache"
grep -q "trex: skin" "$folder/stderr" && complain "the map in the cache is not used"
XDG_CACHE_HOME=/dev/null refuses "/dev/null/embree-cbvh" --scene trex --level 0

# GRID has no error relative to itself: only white and the blue of 0 pixels.
colors=$(tail -c $((65 * 47 * 3)) "$folder/error-grid.ppm" | od -An -v -tu1 -w3 | sort -u | wc -l)
[ "$colors" = 2 ] || complain "$colors colors in the error of GRID"

# Samples smooth only shaded pictures; errors and positions have no mean.
for mode in shading normals error cells blocks; do
  "$program" --scene cube --level 3 --size 65x47 --show $mode --representation cleaf^auto,cvoxel^8 --samples 1 \
    --no-window --output "$folder/once.ppm" 2> /dev/null
  if [ $mode = shading ]; then
    cmp -s "$folder/once.ppm" "$folder/$mode-cleaf^auto-cvoxel^8.ppm" &&
      complain "one sample and sixteen give the same picture"
  else
    cmp "$folder/once.ppm" "$folder/$mode-cleaf^auto-cvoxel^8.ppm" || complain "$mode uses more than one sample"
  fi
done

# The picture equals cbvh_render's with the same number of samples.
for samples in 1 5 16; do
  "$program" --scene cube --level 4 --size 200x100 --representation cvert --samples $samples \
    --no-window --output "$folder/ours.png" 2> /dev/null
  "$render" --scene cube --level 4 --size 200x100 --representation cvert --samples $samples --output "$folder/theirs" \
    > /dev/null 2>&1
  cmp "$folder/ours.png" "$folder/theirs/cube_cvert.png" ||
    complain "a different picture than cbvh_render's of $samples samples"
done

# The same at later times of a motion.
for time in 0 0.5; do
  "$program" --scene cube --motion turn --level 4 --size 200x100 --time $time --no-window \
    --output "$folder/at$time.png" 2> /dev/null
  "$render" --scene cube --motion turn --level 4 --size 200x100 --representation cvert --shutter $time,$time \
    --output "$folder/theirs" > /dev/null 2>&1
  cmp "$folder/at$time.png" "$folder/theirs/cube_cvert.png" ||
    complain "a different picture than cbvh_render's at time $time"
done
cmp -s "$folder/at0.png" "$folder/at0.5.png" && complain "the cube does not rotate"

# Labels do not name what the library builds for motion.
"$program" --scene cube --motion turn --level 2 --size 64x64 --representation cleaf,cleaf-only --no-window \
  --output "$folder/moving.png" 2> "$folder/stderr" || complain "motion: $(cat "$folder/stderr")"
grep -q "^cbvh_viewer: warning: cleaf .*cVERT" "$folder/stderr" &&
  grep -q "^cbvh_viewer: warning: cleaf-only .*GRID" "$folder/stderr" ||
  complain "no warning about blocks with frames: $(cat "$folder/stderr")"

# One thread and two threads must give the same picture.
for threads in 1 2; do
  "$program" --scene cube --level 4 --size 200x100 --threads $threads --no-window \
    --output "$folder/threads$threads.ppm" 2> /dev/null
done
cmp "$folder/threads1.ppm" "$folder/threads2.ppm" || complain "threads change the picture"

# Ctrl-C during a build of 268 million quads: status 130, no file.
awk 'BEGIN { n = 64
  for (y = 0; y <= n; y++) for (x = 0; x <= n; x++) print "v", x, y, 0
  for (y = 0; y < n; y++)
    for (x = 0; x < n; x++) { v = y * (n + 1) + x + 1; print "f", v, v + 1, v + n + 2, v + n + 1 } }' \
  > "$folder/plane.obj"
# GRID is built first, for the camera.
expect_cancellation "grep -q 'GRID: build' '$folder/stderr'" --cage "$folder/plane.obj" --level 8 \
  --no-window --output "$folder/out.png"
[ ! -e "$folder/out.png" ] || complain "a file is left after Ctrl-C"

finish
