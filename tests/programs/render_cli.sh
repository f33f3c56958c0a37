#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# cbvh_render from the outside: what it writes, and one clear line with an exit
# status that is not 0, and nothing written, for bad input.
#
# usage: render_cli.sh PATH/TO/cbvh_render [REPRESENTATIONS]

set -u
program=$1
representations=${2:-naive,grid,cgrid,cvoxel,cleaf}
. "$(dirname -- "$0")/cli.sh"

# refuses PATTERN ARGUMENT...: status not 0 nor a signal's, one line on stderr that
# matches, nothing in the output folder.
refuses() {
  local pattern=$1
  shift
  rm -rf "$folder/out"
  [[ "$*" == *--output* ]] || set -- "$@" --output "$folder/out"
  expect_refusal "$pattern" --no-speed "$@"
  [ -z "$(ls -A "$folder/out" 2>/dev/null)" ] || complain "files were written: $*"
}

sed 's/^f.*/f 1 2/' "$folder/quad.obj" >"$folder/two.obj"
sed 's/^f.*/f 1 2 3 7/' "$folder/quad.obj" >"$folder/range.obj"
sed 's/^f.*/f 1 2 3\nf 2 1 4\nf 1 2 4/' "$folder/quad.obj" >"$folder/edge.obj"
: >"$folder/empty.obj"
echo "no image" >"$folder/text.png"
printf '\x76\x2f\x31\x01\x02\x00\x00\x00' >"$folder/short.exr"

refuses "face needs at least three vertices" --cage "$folder/two.obj"
refuses "index 7 is out of range" --cage "$folder/range.obj"
refuses "not manifold" --cage "$folder/edge.obj"
refuses "no faces" --cage "$folder/empty.obj"
refuses "cannot be opened" --cage "$folder/missing.obj"
refuses "no such height map" --cage "$folder/quad.obj" --height "$folder/missing.exr"
refuses "cannot be read as a height map" --cage "$folder/quad.obj" --height "$folder/text.png"
refuses "cannot be read as a height map" --cage "$folder/quad.obj" --height "$folder/short.exr"
printf 'Ptex' >"$folder/map.ptx"
refuses "map.ptx: " --cage "$folder/quad.obj" --height "$folder/map.ptx"
if command -v oiiotool >/dev/null; then
  oiiotool --pattern noise:type=uniform 64x64 1 -d uint16 -o "$folder/whole.png"
  head -c $(($(stat -c %s "$folder/whole.png") / 2)) "$folder/whole.png" >"$folder/half.png"
  refuses "cannot be read as a height map" --cage "$folder/quad.obj" --height "$folder/half.png"
fi
refuses "unknown representation 'mesh'" --scene cube --representation grid,mesh
refuses "unknown --scene 'teapot', known are cube, frog" --scene teapot
refuses "count 0 is out of range" --scene herd --count 0
refuses "count belongs to --scene herd" --scene frog --count 3
refuses "unknown --mapping 'ptex'" --scene trex --mapping ptex
refuses "level 9 is out of range" --scene cube --level 9
refuses "frame level '9'" --scene cube --frame-level 9
refuses "frame level '9'" --scene cube --representation cleaf^9
refuses "ambient" --scene cube --ambient -1
refuses "size '16'" --scene cube --size 16
refuses "view 'side'" --scene cube --view side
refuses "unknown --isa 'mmx'" --scene cube --isa mmx
refuses "either --scene" --level 2
refuses "either --scene" --scene cube --cage "$folder/quad.obj"
refuses "colour" --scene cube --colour red
refuses "level" --scene cube --level six
refuses "cannot be made an output folder" --scene cube --output "$folder/text.png/out"

if [ "$(id -u)" != 0 ]; then
  mkdir -p "$folder/closed" && chmod a-w "$folder/closed"
  refuses "files cannot be written there" --scene cube --output "$folder/closed"
fi

# What a run leaves.
out="$folder/good"
"$program" --scene cube --level 3 --size 64x48 --rays 2000 --repeat 1 --output "$out" --json "$folder/numbers.json" \
  --representation "$representations" --ambient 4 >"$folder/table" 2>"$folder/stderr" || complain "cube: $(cat "$folder/stderr")"
for representation in ${representations//,/ }; do
  case $representation in c*) stem=${representation}2 ;; *) stem=$representation ;; esac
  for file in "cube_$stem.png" "cube_$stem.exr"; do
    [ -s "$out/$file" ] || complain "no $file"
  done
  [ "$stem" = grid ] || [ -s "$out/cube_${stem}_error.png" ] || complain "no error map of $stem"
  [ "$stem" = grid ] || [ -s "$out/cube_${stem}_ambient.png" ] || complain "no ambient occlusion of $stem"
done
[ -z "$(find "$out" -name '.tmp-*')" ] || complain "temporary files are left"
for row in "bytes a quad" "peak of the build" "build, s" "coherent, closest hit" "incoherent, any hit" \
  "error RMSE" "against the true surface" "false hits" "misses"; do
  grep -q "$row" "$folder/table" || complain "no row '$row' in the table"
done
grep '^| any hit disagrees' "$folder/table" | grep -q '[1-9]' && complain "any hit and closest hit disagree"
grep -q '"bytes_per_quad"' "$folder/numbers.json" || complain "no numbers in the JSON"
if command -v iinfo >/dev/null; then
  for channel in P.X P.Y P.Z Z N.X N.Y N.Z u v primID; do
    iinfo -v "$out/cube_grid.exr" | grep "channel list" | grep -q "\b$channel\b" || complain "no channel $channel"
  done
fi

# Ctrl-C in the middle: status 130, and no half of a file.
"$program" --scene trex --level 6 --output "$folder/cancelled" --representation grid >/dev/null 2>"$folder/stderr" &
process=$!
for _ in $(seq 600); do # until it listens
  [ -d "$folder/cancelled" ] && break
  sleep 0.1
done
kill -INT $process
wait $process
status=$?
[ $status = 130 ] || complain "exit status $status after Ctrl-C: $(cat "$folder/stderr")"
grep -q cancelled "$folder/stderr" || complain "no word on the cancellation"
[ -z "$(ls -A "$folder/cancelled")" ] || complain "files are left after Ctrl-C"

[ $failures = 0 ] && echo "all well"
exit $((failures != 0))
