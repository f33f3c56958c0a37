#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Computes a picture, an animation or a raster in parts, on several machines or cores, and joins the parts.
#
#   farm.sh FOLDER PARTS [WIDTHxHEIGHT] COMMAND ARGUMENT...    computes a part
#   farm.sh --join FOLDER PARTS WIDTHxHEIGHT NAME FILE         joins the files NAME of all parts, with cbvh_render
#
# In arguments of COMMAND, {part} is the number of the part, 0 to PARTS - 1, {output} an existing folder for its files,
# and {crop} its rows of a picture of WIDTHxHEIGHT, as x0,y0,x1,y1. The number comes from Slurm's job array, or from
# MPI, or from the variable FARM_PART:
#
#   sbatch --array=0-7 scripts/farm.sh body 8 4096x4096 \
#     cbvh_render --load body.cbvh --size 4096x4096 --crop '{crop}' --exr --output '{output}'
#   mpirun -n 8 scripts/farm.sh ...
#   seq 0 7 | parallel --quote env FARM_PART={} scripts/farm.sh ...
#
# Files of a part are in FOLDER/part-NUMBER as soon as the command has succeeded. Repeat the whole call after failures:
# parts that are finished are not computed again. Slurm copies this script, so it uses no other file.
set -eu

fail() {
  echo "farm.sh: $*" >&2
  exit 1
}

# Lines of the comment above
usage() {
  sed -n '5,/^$/s/^# \{0,1\}//p' "$0" >&2
  exit 2
}

# No leading zeros: the shell takes them for octal numbers
isNumber() {
  case $1 in
    "" | *[!0-9]* | 0?*) return 1 ;;
  esac
}

# readSize WIDTHxHEIGHT: sets width and height, or fails
readSize() {
  case $1 in
    *x*) ;;
    *) return 1 ;;
  esac
  width=${1%x*}
  height=${1#*x}
  isNumber "$width" && isNumber "$height" && [ "$height" -ge "$parts" ]
}

# rows PART: sets first and last + 1
rows() {
  first=$(($1 * height / parts))
  end=$((($1 + 1) * height / parts))
}

readParts() {
  parts=$1
  isNumber "$parts" && [ "$parts" -ge 1 ] || fail "PARTS is '$parts': expected a number of at least 1"
}

join() {
  [ $# = 5 ] || usage
  folder=$1 name=$4 file=$5
  readParts "$2"
  readSize "$3" || fail "the size is '$3': expected WIDTHxHEIGHT with a row for each of $parts parts"
  size=$3
  set --
  part=0
  while [ "$part" -lt "$parts" ]; do
    [ -e "$folder/part-$part/$name" ] || fail "$folder/part-$part/$name does not exist: part $part is not finished"
    set -- "$@" "$folder/part-$part/$name"
    part=$((part + 1))
  done
  cbvh_render --size "$size" --join "$file" "$@"
}

[ $# -ge 3 ] || usage
if [ "$1" = --join ]; then
  shift
  join "$@"
  exit
fi

folder=$1
readParts "$2"
shift 2
crop=
part=${FARM_PART:-${SLURM_ARRAY_TASK_ID:-${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-}}}}
isNumber "$part" && [ "$part" -lt "$parts" ] ||
  fail "the number of the part is '$part': expected 0 to $((parts - 1)), from a job array, from MPI, or in FARM_PART"
if readSize "$1"; then
  rows "$part"
  crop=0,$first,$width,$end
  shift
fi
[ $# -ge 1 ] || usage

finished=$folder/part-$part
if [ -d "$finished" ]; then
  echo "$finished is finished"
  exit
fi
mkdir -p "$folder"
output=$(mktemp -d "$folder/unfinished-$part-XXXXXX")
chmod +rx "$output" # as far as umask allows
child=
stop() {
  [ -z "$child" ] || {
    kill "$child" 2> /dev/null || true
    wait "$child" || true
  }
  exit "$1"
}
trap 'rm -rf "$output"' EXIT
trap 'stop 143' TERM
trap 'stop 130' INT

# replace TEXT NAME VALUE: sets text, in which VALUE stands for each {NAME}
replace() {
  text=
  rest=$1
  while :; do
    case $rest in
      *"{$2}"*) text=$text${rest%%"{$2}"*}$3 rest=${rest#*"{$2}"} ;;
      *) break ;;
    esac
  done
  text=$text$rest
}

count=$#
while [ "$count" -gt 0 ]; do
  replace "$1" part "$part"
  replace "$text" output "$output"
  case $text in
    *"{crop}"*) [ "$crop" ] || fail "{crop} needs WIDTHxHEIGHT, with a row for each of $parts parts" ;;
  esac
  replace "$text" crop "$crop"
  shift
  set -- "$@" "$text"
  count=$((count - 1))
done
"$@" &
child=$!
wait "$child" || fail "part $part failed with exit status $?"
child=
# Another run may have finished the part meanwhile.
mv -T "$output" "$finished" 2> /dev/null || [ -d "$finished" ] || fail "$finished cannot be made"
