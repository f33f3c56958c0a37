#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests the command line of cbvh_pathtracer: its outputs, and for invalid input one clear line, a nonzero exit status
# and no output file.
#
# usage: pathtracer_cli.sh PATH/TO/cbvh_pathtracer

set -u
program=$1
. "$(dirname -- "$0")/cli.sh"
unset DISPLAY WAYLAND_DISPLAY

# refuses PATTERN ARGUMENT...
refuses() {
  local pattern=$1
  shift
  [[ "$*" == *--output* || "$*" == *--window* ]] || set -- "$@" --output "$folder/out.png"
  expect_refusal "$pattern" "$@"
  [ ! -e "$folder/out.png" ] || complain "a file was written: $*"
}

refuses "scene 'teapot'.*cube, frog" --scene teapot
refuses "scene .*--cage .*--mesh " --level 2
refuses "representation 'mesh'.*naive, naive-compact, grid" --scene cube --representation mesh
refuses "representation 'grid,cleaf' .*one" --scene cube --representation grid,cleaf
refuses "level 9 .* 0 to 8" --scene cube --level 9
refuses "size '16'.*WIDTHxHEIGHT" --scene cube --size 16
refuses "view 'side'.*full, close" --scene cube --view side
refuses "samples.* 0 .* 1 to " --scene cube --samples 0
refuses "bounces.* -1 .* 0 to 64" --scene cube --bounces -1
refuses "shutter '1,0'.* 0 to 1" --scene cube --shutter 1,0
refuses "isa 'mmx'.*avx2" --scene cube --isa mmx
refuses "option --paint" --scene cube --paint red
refuses "out.jpeg'.*exr.*png" --scene cube --output "$folder/out.jpeg"
refuses "output '$folder/missing/out.png': .*$folder/missing" --scene cube --output "$folder/missing/out.png"
refuses "device 'no such device'.*ray-query" --scene cube --level 2 --device "no such device"
refuses "[Vv]ulkan.* 'no such device'" --scene cube --level 2 --device "vulkan:no such device"
refuses "[Vv]ulkan.* 'no such device'" --scene cube --level 2 --device "ray-query:no such device"
refuses "^cbvh_pathtracer: .*window.*--window" --scene cube --window

# On the CPU, which every machine supports.
for output in picture.exr picture.png; do
  "$program" --scene cube --level 2 --size 65x47 --samples 2 --bounces 1 --device cpu --output "$folder/$output" \
    > "$folder/stdout" 2> "$folder/stderr" || complain "$output: $(cat "$folder/stderr")"
  [ -s "$folder/$output" ] || complain "no $output"
done
grep -q "2 samples of 65 x 47 pixels" "$folder/stdout" || complain "says '$(cat "$folder/stdout")'"
[ -z "$(find "$folder" -name '*cbvh-part*')" ] || complain "temporary files are left"

# Labels do not name what the library builds for motion.
"$program" --scene cube --motion turn --level 2 --size 16x16 --samples 1 --device cpu --representation cvoxel \
  --output "$folder/moving.png" > /dev/null 2> "$folder/stderr" || complain "motion: $(cat "$folder/stderr")"
grep -q "^cbvh_pathtracer: warning: cvoxel .*cVERT" "$folder/stderr" ||
  complain "no warning about blocks with frames: $(cat "$folder/stderr")"

# One thread and two threads must give the same picture.
for threads in 1 2; do
  "$program" --scene cube --level 3 --size 64x64 --samples 2 --device cpu --threads $threads \
    --output "$folder/threads$threads.png" > /dev/null 2>&1
done
cmp "$folder/threads1.png" "$folder/threads2.png" || complain "threads change the picture"

# Ctrl-C during rendering, when the scene is built: no file.
expect_cancellation "grep -q 'cTILE: build' '$folder/stderr'" --scene cube --level 2 --samples 1000000 --device cpu \
  --output "$folder/out.png"
[ ! -e "$folder/out.png" ] || complain "a file is left after Ctrl-C"

finish
