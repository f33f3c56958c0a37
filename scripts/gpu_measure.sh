#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# gpu_measure.sh RESULTS [DEVICE] [MINUTES]
#
# Measures every representation on a Vulkan device within MINUTES (default: 20), and writes JSON files for
# scripts/report.py to the folder RESULTS. It runs inside the folder that gpu_bundle.sh made; the machine needs only a
# driver. DEVICE is an index or a part of the device's name (default: the first discrete GPU). The most important runs
# come first. Runs are stopped at the deadline; those that would start less than 30 s before it are skipped with a
# message.

set -eu
case ${1:-} in
  -h | --help)
    sed -n '5,/^$/s/^# \{0,1\}//p' "$0"
    exit 0
    ;;
  -*)
    echo "gpu_measure.sh: unknown option $1, see --help" >&2
    exit 2
    ;;
esac
here=$(cd "$(dirname -- "$0")" && pwd)
results=${1:?usage: gpu_measure.sh RESULTS [DEVICE] [MINUTES]}
device=vulkan${2:+:$2}
minutes=${3:-20}
mkdir -p "$results"
results=$(cd "$results" && pwd)
begin=$(date +%s)
end=$((begin + 60 * minutes))

export LD_LIBRARY_PATH="$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
if ! ldconfig -p 2> /dev/null | grep -q 'libvulkan\.so\.1'; then
  export LD_LIBRARY_PATH="$LD_LIBRARY_PATH:$here/loader"
fi

# Vulkan's loader finds drivers by description files, which containers often lack.
if [ -z "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ]; then
  found=$(ls /etc/vulkan/icd.d/*.json /usr/share/vulkan/icd.d/*.json 2> /dev/null | head -1 || true)
  if [ -z "$found" ]; then
    found=$(ls /usr/local/*/share/vulkan/icd.d/*.json 2> /dev/null | head -1 || true)
    if [ -z "$found" ] && ldconfig -p 2> /dev/null | grep -q 'libGLX_nvidia\.so\.0'; then
      found="$results/nvidia_icd.json"
      icd='{"library_path": "libGLX_nvidia.so.0", "api_version": "1.3.0"}'
      printf '{"file_format_version": "1.0.0", "ICD": %s}\n' "$icd" > "$found"
    fi
    [ -n "$found" ] && export VK_DRIVER_FILES="$found" VK_ICD_FILENAMES="$found"
  fi
fi

# measure NAME SECONDS ARGUMENTS...: runs the benchmark once, for at most SECONDS.
measure() {
  name=$1
  seconds=$2
  shift 2
  left=$((end - $(date +%s)))
  if [ "$left" -lt 30 ]; then
    echo "$name: skipped, the time is over"
    return
  fi
  [ "$seconds" -gt "$left" ] && seconds=$left
  started=$(date +%s)
  if timeout -k 10 "$seconds" "$here/bin/cbvh_bench_bare" --device "$device" --true-surface 0 --rays 0 \
    --size 1024x1024 "$@" --json "$results/$name.json" > "$results/$name.txt" 2> "$results/$name.log"; then
    echo "$name: $(($(date +%s) - started)) s"
  else
    echo "$name: exit status $? after $(($(date +%s) - started)) s; $(tail -1 "$results/$name.log")"
  fi
  grep 'Mrays/s' "$results/$name.txt" | head -40 || true
}

all=grid,ctile,cvert,cleaf-only,naive,cgrid,cvoxel
common="--ray-set coherent,incoherent --query closest,any --repeat 5"

measure frog_6 200 --scene frog --level 6 --representation grid,ctile,cvert,cleaf-only,naive $common
measure trex_6 300 --scene trex --level 6 --representation $all $common
measure others_6 200 --scene cube,knee,scythe --level 6 --representation grid,ctile,cvert,cleaf-only,naive $common
measure close_6 200 --scene trex,frog --view close --level 6 --representation grid,ctile,cvert,cleaf-only $common
measure trex_4_5 200 --scene trex --level 4,5 --representation $all $common
measure trex_7 400 --scene trex --level 7 --representation grid,ctile,cvert,cleaf-only,cvoxel $common
measure others_4_5_7 200 --scene frog,cube,knee --level 4,5,7 --representation grid,ctile,cvert,cleaf-only $common
measure leaks 200 --scene cube --level 5 --representation cvoxel,cleaf-only,cvert,ctile --check leaks,sheets,shadows \
  --check-rays 10000000 --repeat 0
for count in 8 24 64; do
  measure "herd_$count" 300 --scene herd --count $count --level 6 --representation cleaf-only,cvert,ctile \
    --ray-set coherent,incoherent --repeat 3
done

# A row per scene and representation: millions of closest hits per second, and the speed of rays relative to GRID.
table() {
  awk '
    function row() {
      if (name != "" && speed["coherent closest"] != "")
        printf "%-14s %-6s %-14s %6s %10s %10s   %5s %5s %5s %5s\n", scene, view, name, bytes,
          speed["coherent closest"], speed["incoherent closest"], ratio["coherent closest"], ratio["coherent any"],
          ratio["incoherent closest"], ratio["incoherent any"]
      split("", speed)
      split("", ratio)
    }
    /, level / { row(); name = ""; scene = $1 " " $3; gsub(",", "", scene) }
    / B\/quad/ { row(); name = $1; for (i = 2; i <= NF; i++) if ($i ~ /^B\/quad/) bytes = $(i - 1) }
    / Mrays\/s/ {
      if (view != "" && view != $1) row()
      view = $1
      speed[$2 " " $3] = $4
      ratio[$2 " " $3] = $6
    }
    END { row() }' "$1"
}
printf '%-14s %-6s %-14s %6s %10s %10s   %s\n' scene view representation B/quad coherent incoherent \
  "of GRID: coherent closest, any, incoherent closest, any"
for name in frog_6 trex_6 others_6 close_6 trex_4_5 trex_7 others_4_5_7; do
  [ ! -e "$results/$name.txt" ] || table "$results/$name.txt"
done
echo "all: $(($(date +%s) - begin)) s"
