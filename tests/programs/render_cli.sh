#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests the command line of cbvh_render: its outputs, and for invalid input one clear line, a nonzero exit status and
# no output file.
#
# usage: render_cli.sh PATH/TO/cbvh_render [REPRESENTATIONS]

set -u
program=$1
representations=${2:-naive,naive-compact,grid,cgrid,cvoxel,cleaf,cleaf-only}
. "$(dirname -- "$0")/cli.sh"

# refuses PATTERN ARGUMENT...: expects status 1, one matching line on stderr, and an empty output folder.
refuses() {
  local pattern=$1
  shift
  rm -rf "$folder/out"
  [[ "$*" == *--output* ]] || set -- "$@" --output "$folder/out"
  expect_refusal "$pattern" "$@"
  [ -z "$(ls -A "$folder/out" 2> /dev/null)" ] || complain "files were written: $*"
}

sed 's/^f.*/f 1 2 3 7/' "$folder/quad.obj" > "$folder/range.obj"
sed 's/^f.*/f 1 2 3\nf 2 1 4\nf 1 2 4/' "$folder/quad.obj" > "$folder/edge.obj"
{
  cat "$folder/quad.obj"
  echo "t hole 1/0/0 0"
} > "$folder/hole.obj"
{
  sed '/^f/d' "$folder/quad.obj"
  echo "v 2 0 0"
  echo "v 2 1 0"
  echo "f 1 2 3 4"
  echo "f 2 5 6 3"
} \
  > "$folder/two_quads.obj"
echo "no image" > "$folder/text.png"

refuses "range.obj:9: vertex index 7 .* 4 " --cage "$folder/range.obj"
refuses "hole.obj: .*holes" --mesh "$folder/hole.obj"
refuses "missing.obj: " --cage "$folder/missing.obj"
refuses "missing.exr: " --cage "$folder/quad.obj" --height "$folder/missing.exr"
refuses "text.png: .*read" --cage "$folder/quad.obj" --height "$folder/text.png"
if command -v oiiotool > /dev/null; then
  oiiotool --pattern noise:type=uniform 64x64 1 -d uint16 -o "$folder/whole.png"
  head -c $(($(stat -c %s "$folder/whole.png") / 2)) "$folder/whole.png" > "$folder/half.png"
  refuses "half.png: .*read" --cage "$folder/quad.obj" --height "$folder/half.png"
fi
refuses "representation 'mesh'.*naive, naive-compact, grid" --scene cube --representation grid,mesh
refuses "option --representaton, .*--representation" --scene cube --representaton grid
refuses "amplitude 'x': .*number" --scene cube --amplitude x
refuses "exr 'x': .*no value" --scene cube --exr=x
refuses "scene 'teapot'.*cube, frog" --scene teapot
for option in --json --export --save; do
  refuses "${option#--} '$folder/missing/x': .*$folder/missing" --scene cube "$option" \
    "$folder/missing/x"
done
for option in --rays --true-surface; do
  refuses "${option#--}: .*-1" --scene cube --speed $option -1
done
refuses "count 0 .* 1 to 100000" --scene herd --count 0
refuses "count .*--scene herd" --scene frog --count 3
refuses "mapping 'ptex'.*faces.*atlas" --scene trex --mapping ptex
refuses "level 9 .* 0 to 8" --scene cube --level 9
refuses "frame level '9'.* 0 to 8" --scene cube --frame-level 9
refuses "frame level '9'.* 0 to 8" --scene cube --representation cleaf^9
refuses "ambient.* -1 .* 0 to 4096" --scene cube --ambient -1
refuses "size '16'.*WIDTHxHEIGHT" --scene cube --size 16
refuses "view 'side'.*full, close" --scene cube --view side
refuses "isa 'mmx'.*avx2" --scene cube --isa mmx
refuses "scene .*--cage .*--mesh " --level 2
refuses "scene .*--cage .*--mesh " --scene cube --cage "$folder/quad.obj"
refuses "option --paint" --scene cube --paint red
refuses "level 'six'.* 0 to 8 or auto" --scene cube --level six
refuses "$folder/text.png/out: .*Not a directory" --scene cube --output "$folder/text.png/out"

for wrong in 0 -1 nan inf; do
  refuses "quad-size $wrong: .* 0" --scene cube "--quad-size=$wrong"
done
refuses "quad-size .*--level auto" --scene cube --level 3 --quad-size 2
refuses "level auto .*naive" --scene cube --level auto --representation naive
refuses "level auto .*naive-compact" --scene cube --level auto --representation naive-compact
refuses "max-pixel-error nan: .*finite.* 0" --scene cube --max-pixel-error nan

refuses "height-repeat 'many'.*3x2" --cage "$folder/quad.obj" --height "$folder/text.png" --height-repeat many
refuses "height-wrap.* mirror .*clamp.*repeat.*black" --cage "$folder/quad.obj" --height "$folder/text.png" \
  --height-wrap mirror
refuses "height-wrap .*--height" --cage "$folder/quad.obj" --height-wrap clamp
refuses "mid-level .*--height" --cage "$folder/quad.obj" --mid-level 0.2
refuses "vectors.* world .*object.*tangent" --cage "$folder/quad.obj" --height "$folder/text.png" --vectors world
refuses "amplitude .*--height-scale " --cage "$folder/quad.obj" --height "$folder/text.png" \
  --amplitude 1 --height-scale 1
refuses "up.* w .*auto.*-z" --cage "$folder/quad.obj" --up w
refuses "up .*--cage" --scene cube --up z
refuses "colors.* magenta .*neutral.*sides" --scene cube --colors magenta
refuses "level .* 2 times" --scene cube --level 2 --level 3
refuses "samples.* 0 .* 1 to " --scene cube --samples 0
refuses "representation .*--compare" --scene cube --compare --representation grid
refuses "quad.obj: --scene .*--cage " --scene cube "$folder/quad.obj"
refuses "text.png: .*cage" "$folder/text.png"
mkfifo "$folder/pipe.png"
refuses "pipe.png: .*pipe" --cage "$folder/quad.obj" --height "$folder/pipe.png"

if [ "$(id -u)" != 0 ]; then
  mkdir -p "$folder/closed" && chmod a-w "$folder/closed"
  refuses "$folder/closed: " --scene cube --output "$folder/closed"
fi

# Outputs of a run.
# run NAME OPTION...: writes the table to $folder/NAME, messages to a file next to it, and pictures to a folder of
# that name.
run() {
  local name=$1
  shift
  "$program" --level 3 --size 64x48 --rays 2000 --repeat 1 --output "$folder/$name.out" "$@" \
    > "$folder/$name" 2> "$folder/$name.err" || complain "$name: $(cat "$folder/$name.err")"
}
run_file() { # a file has a fixed level
  local name=$1
  shift
  "$program" --size 64x48 --output "$folder/$name.out" "$@" > "$folder/$name" 2> "$folder/$name.err" ||
    complain "$name: $(cat "$folder/$name.err")"
}
expect_rows() {
  local table=$1
  shift
  for row in "$@"; do
    grep -q "^| $row" "$folder/$table" || complain "no row '$row' in $table: $(cat "$folder/$table")"
  done
}
rows() { grep -c '^| [^ ]' "$folder/$1"; } # the head is not one: its first cell is empty

out="$folder/good.out"
run good --scene cube --json "$folder/numbers.json" --representation "$representations" --speed --exr --ambient 4
for representation in ${representations//,/ }; do
  stem=$representation
  for file in "cube_$stem.png" "cube_$stem.exr" "cube_${stem}_ambient.png"; do
    [ -s "$out/$file" ] || complain "no $file"
  done
  [ "$stem" = grid ] || [ -s "$out/cube_${stem}_error.png" ] || complain "no error map of $stem"
done
[ -z "$(find "$out" -name '*cbvh-part*')" ] || complain "temporary files are left"
expect_rows good "bytes per quad" "quads stored as cVERT, %.* [0-9.]* |     *- |$" "peak of the build" \
  "build, s" "coherent rays" "incoherent rays" "error against the mesh" \
  "error against the true surface, pixels: median, p99" "false hits + misses" "flipped normals"
[ "$(rows good)" -le 11 ] || complain "$(rows good) rows"
grep -q "^  $out/cube_{.*}.png: shaded" "$folder/good" || complain "no message about where the pictures are"
grep -q '"bytes_per_quad"' "$folder/numbers.json" || complain "no numbers in the JSON"
if command -v iinfo > /dev/null; then
  for channel in P.X P.Y P.Z Z N.X N.Y N.Z u v primID; do
    iinfo -v "$out/cube_grid.exr" | grep "channel list" | grep -q "\b$channel\b" || complain "no channel $channel"
  done
fi

# A cage from a pipe gives the same picture.
run from_file "$folder/quad.obj" --representation cvert
run from_pipe <(cat "$folder/quad.obj") --representation cvert
cmp "$folder"/from_file.out/*_cvert.png "$folder"/from_pipe.out/*_cvert.png ||
  complain "a different picture from the pipe"

# A file gives the same picture without the model.
run saved --scene cube --representation cvert --view 3,2,4,0,0,0,40 --save "$folder/cube.cbvh"
run_file loaded --load "$folder/cube.cbvh" --view 3,2,4,0,0,0,40
cmp "$folder/saved.out/cube_cvert.png" "$folder/loaded.out/cube_cvert.png" ||
  complain "a different picture from the file"
grep -q "opened in" "$folder/loaded" || complain "no message about how long opening took"
run_file loaded_close "$folder/cube.cbvh" --view close --speed --rays 2000 --repeat 1 --json "$folder/loaded.json"
grep -q "speed: one thread, single rays: [0-9.]*[1-9][0-9.]* million coherent rays" "$folder/loaded_close" ||
  complain "no speed from the file: $(cat "$folder/loaded_close")"
for key in speed incoherent mrays_per_second picture_seconds; do
  grep -q "\"$key\"" "$folder/loaded.json" || complain "no $key of the file"
done
"$program" --load "$folder/cube.cbvh" --size 64x1 --output "$folder/row.out" > /dev/null 2> "$folder/stderr" ||
  complain "a file in a single row of pixels: $(cat "$folder/stderr")"
run_file loaded_up --load "$folder/cube.cbvh" --up z
run_file loaded_full --load "$folder/cube.cbvh"
cmp -s "$folder/loaded_up.out/cube_cvert.png" "$folder/loaded_full.out/cube_cvert.png" &&
  complain "--up has no effect on a file"
# A herd is written copy by copy, and its picture is rendered from the file. A partial file of a different build must
# remain. The map is stored in the user's cache, not next to the pictures.
herd="--scene herd --count 2 --mapping atlas --representation cvert"
run herd $herd
[ -s "$folder/cache/embree-cbvh/trex_height_atlas.exr" ] || complain "no map in the user's cache"
ls "$folder/herd.out" | grep -q height && complain "a map among the pictures: $(ls "$folder/herd.out")"
run herd_saved $herd --save "$folder/herd.cbvh"
cmp "$folder/herd.out/herd_cvert.png" "$folder/herd_saved.out/herd_cvert.png" ||
  complain "a different picture of a herd from its file"
grep -q "2 geometries, 0 of them " "$folder/herd_saved" ||
  complain "no message about the build"
[ ! -e "$folder/herd.cbvh.part" ] || complain "a partial file was left"
refuses "save .*herd .*--ambient" $herd --save "$folder/herd.cbvh" --ambient 4
echo mesh > "$folder/herd.cbvh.part"
refuses "invalid argument: .*herd.cbvh.part: .*compressed" $herd --save "$folder/herd.cbvh"
refuses "invalid argument: .*text.png: .* 9 bytes" --load "$folder/text.png"
refuses "cube.cbvh: .*--compare" "$folder/cube.cbvh" --compare
refuses "cube.cbvh: .*--level" --load "$folder/cube.cbvh" --level 3
refuses "cube.cbvh: .*alone.*model" --scene cube "$folder/cube.cbvh"
refuses "load .*--scene" --scene cube --load "$folder/cube.cbvh"
refuses "save .*representation" --scene cube --representation grid --save "$folder/none.cbvh"

run details --scene cube --representation "$representations" --speed --details
expect_rows details "- leaves" "coherent, closest hit" "incoherent, any hit" "against the mesh: error, pixels, median" \
  "- the paper.s RMSE" \
  "against the true surface" "- false hits" "- misses" "- flipped normals"
[ "$(rows details)" -gt 40 ] || complain "$(rows details) rows with --details"
expect_rows details "any-hit disagreements, coherent" "any-hit disagreements, incoherent"
grep '^| any-hit disagreements' "$folder/details" | grep -q '[1-9]' && complain "any hit and closest hit disagree"

# A single representation gives the same picture, without outputs that require GRID or a clock.
run alone --scene cube --representation cleaf --true-surface 1000
cmp -s "$folder/alone.out/cube_cleaf.png" "$out/cube_cleaf.png" || complain "a different picture without GRID"
[ "$(ls "$folder/alone.out")" = cube_cleaf.png ] || complain "not one picture alone: $(ls "$folder/alone.out")"
[ "$(head -1 "$folder/alone")" = "$folder/alone.out/cube_cleaf.png" ] ||
  complain "the picture is not named first: $(head -1 "$folder/alone")"
grep -q "GRID: build" "$folder/alone.err" && complain "GRID was built: $(cat "$folder/alone.err")"
grep -qi "speed\|GRID\|mesh" "$folder/alone" && complain "words on what was not measured: $(cat "$folder/alone")"
expect_rows alone "error against the true surface" "flipped normals"

# Names of the library's kinds are accepted everywhere, in any case. --compare contains each kind once, and the share
# of fallback quads appears only for kinds that may have some.
run names --scene cube --representation cbvh.LEAF --true-surface 1000
cmp -s "$folder/names.out/cube_cleaf.png" "$folder/alone.out/cube_cleaf.png" || complain "cbvh.LEAF differs from cleaf"
run compare --scene cube --compare --true-surface 0
head -9 "$folder/compare" | grep -q "^| *| *NAIVE | *NAIVE-compact | *GRID | *cGRID | *cVOXEL | *cLEAF | *cVERT |" ||
  complain "--compare has different columns: $(cat "$folder/compare")"
expect_rows compare "quads stored as cVERT, %"
run only --scene cube --representation grid,leaf-only^2 --true-surface 0
grep -q "cLEAF-only^2" "$folder/only" || complain "no cLEAF-only^2: $(cat "$folder/only")"
[ -s "$folder/only.out/cube_cleaf-only2.png" ] || complain "no file of cleaf-only2"
grep -q "stored as cVERT" "$folder/only" && complain "a row on quads stored as cVERT without cLEAF"

# Files suffice: a cage, and optionally a map. The picture is rendered in cVERT and equals the one with explicit
# options.
run files "$folder/quad.obj"
[ "$(ls "$folder/files.out")" = quad_ctile.png ] || complain "not one picture of cTILE: $(ls "$folder/files.out")"
[ "$(rows files)" = 4 ] || complain "rows on what was not asked for: $(cat "$folder/files")"
if [ -s "$folder/whole.png" ]; then
  run file_and_map "$folder/quad.obj" "$folder/whole.png"
  run options --cage "$folder/quad.obj" --height "$folder/whole.png"
  cmp -s "$folder/file_and_map.out/quad_ctile.png" "$folder/options.out/quad_ctile.png" ||
    complain "files and options differ"
  cmp -s "$folder/file_and_map.out/quad_ctile.png" "$folder/files.out/quad_ctile.png" &&
    complain "the map has no effect"
fi

# A cage that moves to another one: at the end of the shutter the picture equals the other's, and in between it is
# blurred.
sed 's/^v \([01]\) \(.*\)/v \1.5 \2/' "$folder/quad.obj" > "$folder/end.obj"
view=(--view 0.9,0.5,4,0.9,0.5,0,40 --representation cvert)
run at_end --cage "$folder/quad.obj" --cage-end "$folder/end.obj" --shutter 1,1 "${view[@]}"
run of_end --cage "$folder/end.obj" "${view[@]}"
run blurred --cage "$folder/quad.obj" --cage-end "$folder/end.obj" "${view[@]}"
cmp -s "$folder/at_end.out/quad_cvert.png" "$folder/of_end.out/end_cvert.png" ||
  complain "the end of --cage-end is not that cage"
cmp -s "$folder/at_end.out/quad_cvert.png" "$folder/blurred.out/quad_cvert.png" && complain "nothing is blurred"
refuses "shutter '2,3'.* 0 to 1" --cage "$folder/quad.obj" --cage-end "$folder/end.obj" --shutter 2,3
refuses "end.obj" --cage "$folder/two_quads.obj" --cage-end "$folder/end.obj"

# A cage that is clearly z up stands upright automatically, with a message. A cage with y up remains unchanged.
cat > "$folder/tower.obj" << OBJ
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v -0.4 -0.4 3
v 0.4 -0.4 3
v 0.4 0.4 3
v -0.4 0.4 3
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
OBJ
for up in auto y z; do
  run "tower_$up" --cage "$folder/tower.obj" --representation cvert --up $up
done
run tower --cage "$folder/tower.obj" --representation cvert
cmp -s "$folder/tower.out/tower_cvert.png" "$folder/tower_z.out/tower_cvert.png" ||
  complain "a tower with z up does not stand upright"
cmp -s "$folder/tower.out/tower_cvert.png" "$folder/tower_auto.out/tower_cvert.png" ||
  complain "--up auto differs from the default"
cmp -s "$folder/tower.out/tower_cvert.png" "$folder/tower_y.out/tower_cvert.png" && complain "--up has no effect"
grep -q "tower.obj: z .*up axis.*--up y" "$folder/tower.err" ||
  complain "no message about the guess: $(cat "$folder/tower.err")"
grep -q "up axis" "$folder/tower_y.err" "$folder/tower_z.err" "$folder/alone.err" "$folder/files.err" &&
  complain "a message although nothing was guessed"

# Several samples smooth the picture. The library chooses frame levels by default.
run one_sample --scene cube --representation cleaf --samples 1
cmp -s "$folder/one_sample.out/cube_cleaf.png" "$folder/alone.out/cube_cleaf.png" &&
  complain "one sample and sixteen give the same picture"
run frames --scene cube --representation cleaf^0,cleaf --json "$folder/frames.json"
[ "$(grep -c '"blocks": 6,' "$folder/frames.json")" = 2 ] ||
  complain "the number of blocks of level 3 is wrong: $(grep '"blocks"' "$folder/frames.json")"

# Without a level, quads have the requested size. --compare and --representation with several entries use level 6.
for quad in 4 16; do
  "$program" --scene cube --size 64x48 --quad-size $quad --json "$folder/quad$quad.json" --output "$folder/quad$quad" \
    > "$folder/quad$quad.txt" 2>&1 ||
    complain "--quad-size $quad: $(cat "$folder/quad$quad.txt")"
  grep -q "level auto" "$folder/quad$quad.txt" || complain "the level is not auto: $(cat "$folder/quad$quad.txt")"
done
quads() { grep -o '"quads": [0-9]*' "$folder/$1.json" | tail -1 | grep -o '[0-9]*$'; }
[ "$(quads quad4)" -ge $((8 * $(quads quad16))) ] || complain "$(quads quad4) quads of 4 pixels, $(quads quad16) of 16"
"$program" --scene cube --size 64x48 --representation grid,cvert --true-surface 0 --output "$folder/fixed" 2>&1 |
  grep -q "level 6" || complain "comparisons do not use level 6"

# A separate mode colors back faces magenta.
sed 's/^f.*/f 4\/4 3\/3 2\/2 1\/1/' "$folder/quad.obj" > "$folder/back.obj"
for colors in neutral sides; do
  for side in quad back; do
    run "${side}_$colors" --cage "$folder/$side.obj" --representation grid --colors $colors \
      --view 0.5,0.5,3,0.5,0.5,0,35
  done
done
picture() { cat "$folder/$1.out/"*.png; }
[ "$(picture quad_neutral | cksum)" = "$(picture back_neutral | cksum)" ] || complain "sides look different by default"
[ "$(picture quad_sides | cksum)" = "$(picture quad_neutral | cksum)" ] || complain "the outside is colored"
[ "$(picture back_sides | cksum)" != "$(picture back_neutral | cksum)" ] ||
  complain "--colors sides does not mark the inside"
grep -q "magenta" "$folder/back_sides" || complain "no message about what magenta is"

# Cages that Embree treats by its own rules: a message and a picture.
run edge --cage "$folder/edge.obj" --representation cleaf
grep -q "cbvh_render: warning: .*edge.obj: .*1 edge" "$folder/edge.err" ||
  complain "no message about an edge of three faces"

# Exporting and importing gives the same picture bit by bit, for meshes of quads, triangles, and both.
for scene in cube frog; do
  run out_$scene --scene $scene --view 3,2,4,0,0,0,35 --export "$folder/$scene.obj"
  run in_$scene --mesh "$folder/$scene.obj" --view 3,2,4,0,0,0,35
  cmp -s "$folder/out_$scene.out/${scene}_ctile.png" "$folder/in_$scene.out/${scene}_ctile.png" ||
    complain "$scene differs as a mesh"
done
awk '$1 == "f" { print "f", $2, $3, $5; print "f", $3, $4, $5; next } { print }' "$folder/cube.obj" \
  > "$folder/triangles.obj"
awk '$1 == "f" && NR % 2 { print "f", $2, $3, $5; print "f", $3, $4, $5; next } { print }' "$folder/cube.obj" \
  > "$folder/both.obj"
for mesh in triangles both; do
  run $mesh --mesh "$folder/$mesh.obj" --compare --view 3,2,4,0,0,0,35
  grep -q "^| false hits + misses *| *- *| *0 + 0 *| *0 + 0 *|" "$folder/$mesh" ||
    complain "$mesh: hits of a mesh: $(cat "$folder/$mesh")"
done
cmp -s "$folder/out_cube.out/cube_ctile.png" "$folder/triangles.out/triangles_ctile.png" ||
  complain "triangles differ from quads"
{
  cat "$folder/cube.obj"
  echo "t hole 1/0/0 7"
} > "$folder/hole.obj"
run hole --mesh "$folder/hole.obj" --compare
faces=$(grep -c "^f" "$folder/cube.obj")
grep -q "^hole: $((faces - 1)) faces" "$folder/hole" || complain "a hole has faces: $(cat "$folder/hole")"
run plain --mesh "$folder/quad.obj"
grep -q "^| bytes per quad *| *[1-9]" "$folder/plain" ||
  complain "a mesh of one quad is not stored: $(cat "$folder/plain" "$folder/plain.err")"
for i in 1 2 3 4 5; do echo "v $i $((i * i)) 0"; done > "$folder/five.obj"
echo "f 1 2 3 4 5" >> "$folder/five.obj"
run five --mesh "$folder/five.obj" --representation grid
grep -q "^five: 3 faces" "$folder/five" || complain "a pentagon is not three triangles: $(cat "$folder/five")"
printf 'ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty int x\n' > "$folder/short.ply"
refuses "short.ply:5: .*end_header" --mesh "$folder/short.ply"
{
  printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\n'
  printf 'element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n'
} > "$folder/one.ply"
run one --mesh "$folder/one.ply" --representation grid
grep -q "^one: 1 faces" "$folder/one" || complain "a PLY file has other faces: $(cat "$folder/one")"
refuses "scene .*--cage .*--mesh " --mesh "$folder/quad.obj" --scene cube
refuses "height .*meshes" --mesh "$folder/quad.obj" --height "$folder/text.png"
refuses "true-surface .*cage" --mesh "$folder/quad.obj" --true-surface 100
run moving --scene cube --motion turn --representation grid,cgrid,cleaf-only,cvert
grep -q "warning: cgrid .*cVERT" "$folder/moving.err" && grep -q "warning: cleaf-only .*GRID" "$folder/moving.err" &&
  ! grep -q "warning: cvert" "$folder/moving.err" || complain "moving models: $(cat "$folder/moving.err")"
refuses "true-surface .*--motion" --scene cube --motion turn --true-surface 100
refuses "export .*ctile.*cvert.*--representation" --scene cube --representation grid --export "$folder/none.obj"
expect_refusal "mesh.* cLEAF.*grid.*cvert" --mesh "$folder/quad.obj" --representation cleaf --size 16x16 \
  --output "$folder/cleaf.out"

# Standard output that cannot be written.
for arguments in --help "--scene cube --level 1 --size 16x16 --representation grid --output $folder/full"; do
  # shellcheck disable=SC2086
  "$program" $arguments > /dev/full 2> "$folder/stderr" && complain "status 0 on a full disk: $arguments"
  grep -q "standard output .*No space left" "$folder/stderr" || complain "no message about a full disk: $arguments"
done

# Ctrl-C while a map is generated: status 130, and no partial file.
# The program handles signals once the folder exists.
expect_cancellation "[ -d '$folder/interrupted' ]" --scene trex --level 6 --output "$folder/interrupted" \
  --representation grid
[ -z "$(ls -A "$folder/interrupted")" ] || complain "files are left after Ctrl-C"
ls -A "$folder/cache/embree-cbvh" | grep -q part && complain "half a map is left after Ctrl-C"

finish
