#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests the outputs of programs: they follow links, write into pipes and devices, never overwrite inputs of a run, and
# never leave partial files.
#
# usage: outputs_cli.sh PATH/TO/cbvh_render PATH/TO/cbvh_bench [PATH/TO/cbvh_pathtracer [PATH/TO/cbvh_viewer]]

set -u
render=$1 bench=$2 pathtracer=${3:-} viewer=${4:-}
program=$render
. "$(dirname -- "$0")/cli.sh"

quick="--level 2 --size 32x24 --samples 1"
out="--output $folder/out"
printf 'P5\n4 4\n255\n0123456789abcdef' > "$folder/skin.pgm"
cp "$folder/skin.pgm" "$folder/quad_ctile.png" # as the picture of the quad is called
sums() { cksum "$folder/quad.obj" "$folder/skin.pgm" "$folder/quad_ctile.png" "$folder/cube.cbvh" 2> /dev/null; }
# shellcheck disable=SC2086
run() {
  timeout 100 "$program" $quick $out "$@" 2> "$folder/stderr" || complain "status $?: $* : $(cat "$folder/stderr")"
}
is_json() { python3 -c 'import json, sys; json.load(open(sys.argv[1]))' "$1" || complain "no JSON: $1"; }
is_about_a_pipe() { grep -q "invalid argument: .*fifo.cbvh: .*pipe" "$folder/stderr"; }
parts() { find "$folder" -name '*cbvh-part*' -o -name '.tmp-*'; }

# --- links, devices and pipes ---------------------------------------------------------------

mkdir "$folder/store"
ln -s store/numbers.json "$folder/link.json"
for _ in 1 2; do # first without the file, then with it
  run --scene cube --json "$folder/link.json" > /dev/null
  is_json "$folder/store/numbers.json"
  [ -L "$folder/link.json" ] || complain "the link is replaced"
done
chmod 604 "$folder/store/numbers.json"
run --scene cube --json "$folder/link.json" > /dev/null
mode=$(stat -c %a "$folder/store/numbers.json")
[ "$mode" = 604 ] || complain "other permissions: $mode"

ln -s /dev/null "$folder/null"
run --scene cube --json "$folder/null" --export /dev/null > /dev/null
[ -L "$folder/null" ] && [ -c /dev/null ] || complain "a device is replaced"
run --scene cube --json /dev/stdout > "$folder/both"
python3 - "$folder/both" << 'PYTHON' || complain "no JSON on standard output"
import json, sys
text = open(sys.argv[1]).read()
json.JSONDecoder().raw_decode(text, text.index("{\n"))
PYTHON
grep -q "cube_ctile.png" "$folder/both" || complain "the JSON replaced the table: $(cat "$folder/both")"
run --scene cube --json >(cat > "$folder/substituted") --export >(cat > "$folder/exported") > /dev/null
wait
sleep 1
is_json "$folder/substituted"
grep -q "^f " "$folder/exported" || complain "no mesh through a pipe"
mkfifo "$folder/fifo"
cat "$folder/fifo" > "$folder/from_fifo" &
run --scene cube --json "$folder/fifo" > /dev/null
wait
is_json "$folder/from_fifo"
[ -p "$folder/fifo" ] || complain "a FIFO is replaced"
for where in /dev/null "$folder/fifo" /dev/stdout; do
  # shellcheck disable=SC2086
  expect_refusal "invalid argument: $where: .*regular" $quick $out --scene cube --save "$where"
done

# A name that is not UTF-8 is readable JSON.
for name in $'caf\351.obj' $'quad\xff.obj'; do
  cp "$folder/quad.obj" "$folder/$name"
  run "$folder/$name" --json "$folder/byte.json" > /dev/null
  is_json "$folder/byte.json"
done
run --scene cube --save "$folder"/$'cube\xff.cbvh' > /dev/null
"$program" "$folder"/$'cube\xff.cbvh' --size 32x24 --output "$folder/out" --json "$folder/byte2.json" > /dev/null 2>&1
is_json "$folder/byte2.json"
"$bench" --scene cube --level 2 --representation grid --repeat 0 --size 16x16 --json "$folder"/$'byte\xff.json' \
  > /dev/null 2>&1
is_json "$folder"/$'byte\xff.json'

# Reading a FIFO must not block.
mv "$folder/fifo" "$folder/fifo.cbvh"
for arguments in "--load $folder/fifo.cbvh" "$folder/fifo.cbvh"; do
  # shellcheck disable=SC2086
  timeout 30 "$program" $out $arguments > /dev/null 2> "$folder/stderr"
  [ $? = 1 ] || complain "reading a FIFO blocks: $arguments"
  is_about_a_pipe || complain "no message about a FIFO: $(cat "$folder/stderr")"
done
if [ -n "$viewer" ]; then
  timeout 30 "$viewer" "$folder/fifo.cbvh" --no-window --output "$folder/none.png" > /dev/null 2> "$folder/stderr"
  [ $? = 1 ] && is_about_a_pipe || complain "the viewer blocks on a FIFO: $(cat "$folder/stderr")"
fi
rm "$folder/fifo.cbvh"

# --- inputs --------------------------------------------------------------------------------

run --scene cube --save "$folder/cube.cbvh" > /dev/null
ln -s quad.obj "$folder/cage"
before=$(sums)
model="--cage $folder/quad.obj --height $folder/skin.pgm"
for arguments in "--save $folder/skin.pgm" "--save $folder/quad.obj" "--json $folder/skin.pgm" \
  "--export $folder/cage" "--json $folder/./quad.obj"; do
  option=${arguments%% *}
  # shellcheck disable=SC2086
  expect_refusal "${option#--} .*${arguments#* }: .*input" $quick $out $model $arguments
done
# shellcheck disable=SC2086
expect_refusal "json .*$folder/cage: .*$folder/quad.obj.*input" $quick $out --mesh "$folder/quad.obj" \
  --json "$folder/cage"
# shellcheck disable=SC2086
expect_refusal "json .*$folder/quad_ctile.png: .*input" $quick $out $model --cage-end "$folder/quad_ctile.png" \
  --json "$folder/quad_ctile.png"
expect_refusal "json .*$folder/cube.cbvh: .*input" --load "$folder/cube.cbvh" --json "$folder/cube.cbvh"
# shellcheck disable=SC2086
expect_refusal "json $folder/same: .*--export" $quick $out --scene cube --json "$folder/same" \
  --export "$folder/./same"
# shellcheck disable=SC2086
expect_refusal "$folder/quad_ctile.png: .*input" $quick --cage "$folder/quad.obj" \
  --height "$folder/quad_ctile.png" --output "$folder"
cp "$folder/skin.pgm" "$folder/tile.1001.pgm"
# shellcheck disable=SC2086
expect_refusal "$folder/tile.1001.pgm: .*input" $quick $out --cage "$folder/quad.obj" \
  --height "$folder/tile.<UDIM>.pgm" --save "$folder/tile.1001.pgm"
cmp "$folder/skin.pgm" "$folder/tile.1001.pgm" || complain "a tile is replaced"
program=$bench
# shellcheck disable=SC2086
expect_refusal "json .*$folder/skin.pgm: .*input" $model --level 2 --json "$folder/skin.pgm"
if [ -n "$pathtracer" ]; then
  program=$pathtracer
  # shellcheck disable=SC2086
  expect_refusal "output .*$folder/quad_ctile.png: .*input" --cage "$folder/quad.obj" \
    --height "$folder/quad_ctile.png" --device cpu --output "$folder/quad_ctile.png"
fi
if [ -n "$viewer" ]; then
  program=$viewer
  # shellcheck disable=SC2086
  expect_refusal "output .*$folder/skin.pgm: .*input" $model --no-window --output "$folder/skin.pgm"
fi
[ "$(sums)" = "$before" ] || complain "an input has changed"
[ -z "$(parts)" ] || complain "parts are left: $(parts)"

# --- outputs that cannot be written ----------------------------------------------------------

program=$render
for option in --save --export --json; do
  # shellcheck disable=SC2086
  expect_refusal "${option#--} $folder: .*Is a directory" $quick \
    --output "$folder/early" --scene cube "$option" "$folder"
done
[ -z "$(ls -A "$folder/early")" ] || complain "rendered before the outputs were checked"
program=$bench
expect_refusal "json $folder: .*Is a directory" --scene cube --level 2 --size 16x16 --json "$folder"
[ ! -s "$folder/stdout" ] || complain "measured before the output was checked"

# --- limits on the size of files -----------------------------------------------------------

# expect_limit KIBIBYTES ARGUMENT...: expects one line about a file that is too large, status 1, and no partial file
# in $folder/limited.
expect_limit() {
  local limit=$1
  shift
  rm -rf "$folder/limited"
  mkdir "$folder/limited"
  # shellcheck disable=SC2086
  # the limit does not apply to cat
  (
    ulimit -f "$limit"
    exec "$program" $quick "$@" 2>&1 > /dev/null
  ) | cat > "$folder/stderr"
  local status=${PIPESTATUS[0]}
  [ $status = 1 ] || complain "status $status for a limit of $limit KiB: $*: $(cat "$folder/stderr")"
  [ "$(grep -vc '^  ' "$folder/stderr")" = 1 ] && grep -q "File too large" "$folder/stderr" ||
    complain "no line on a limit: $*: $(cat "$folder/stderr")"
  [ -z "$(find "$folder/limited" -type f ! -name '*.png')" ] || complain "files are left: $(ls -Al "$folder/limited")"
  [ -z "$(parts)" ] || complain "parts are left: $(parts)"
}
program=$render
expect_limit 1 --scene cube --output "$folder/limited" --exr
expect_limit 0 --scene cube --output "$folder/out" --json "$folder/limited/x"
expect_limit 4 --scene cube --output "$folder/out" --export "$folder/limited/x"
expect_limit 4 --scene cube --output "$folder/out" --save "$folder/limited/x"
expect_limit 4 --scene herd --count 2 --output "$folder/out" --save "$folder/limited/x"

# --- standard output -----------------------------------------------------------------------

if [ -n "$pathtracer" ]; then
  "$pathtracer" --scene cube --level 1 --size 16x16 --samples 1 --device cpu --output "$folder/path.png" \
    > /dev/full 2> "$folder/stderr"
  [ $? = 1 ] && grep -q "standard output .*No space left" "$folder/stderr" ||
    complain "no message about a full disk: $(cat "$folder/stderr")"
fi

finish
