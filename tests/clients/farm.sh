#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Slurm renders a picture in eight parts, and one part is killed. Slurm, GNU parallel and MPI compute a raster in eight
# parts. The joined picture and rasters equal those of one process, bit for bit.
#
#   farm.sh SCRIPTS-FOLDER CBVH_RENDER CBVH_TERRAIN
#
# Starts Slurm's daemons and munged with files in a temporary folder, and four nodes on this machine. Prints that it is
# skipped, and exits with 77, if it is not run by root or lacks a program.
set -eu
farm=$1/farm.sh
render=$2
terrain=$3
PATH=$(dirname "$render"):$PATH

skip() {
  echo "skipped: $*"
  exit 77
}
[ "$(id -u)" = 0 ] || skip "the daemons of Slurm need root"
for program in munged slurmctld slurmd sbatch oiiotool parallel mpirun; do
  command -v "$program" > /dev/null || skip "no $program: install munge, slurmctld, slurmd, slurm-client," \
    "openimageio-tools, parallel and openmpi-bin"
done

folder=$(mktemp -d)
cd "$folder"
stop() {
  [ ! -e ctld.pid ] || scontrol shutdown || true
  tries=0
  while ls ./*.pid > /dev/null 2>&1 && [ "$tries" -lt 100 ]; do
    [ "$(ls ./*.pid)" != ./munge.pid ] || break
    tries=$((tries + 1))
    sleep 0.1
  done
  [ ! -e munge.socket ] || munged --stop --socket="$folder/munge.socket" || true
  tail -n 5 slurm-*.out 2> /dev/null || true
  cd /
  rm -rf "$folder" || true
}
trap stop EXIT
trap 'exit 143' TERM INT

# --- Slurm -------------------------------------------------------------------------

# Ports that are free now, as other tests may run on this machine
port=$(python3 -c '
import socket
sockets = [socket.socket() for _ in range(32)]
for s in sockets: s.bind(("127.0.0.1", 0))
ports = sorted(s.getsockname()[1] for s in sockets)
print(next(p for p in range(ports[0] + 1, 65000) if not {*range(p, p + 5)} & {*ports}))')

mkdir state
dd if=/dev/urandom of=munge.key bs=128 count=1 2> /dev/null
chmod 400 munge.key
cat > slurm.conf << END
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
SlurmctldPort=$port
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool-%n
SlurmctldPidFile=$folder/ctld.pid
SlurmdPidFile=$folder/%n.pid
SlurmctldLogFile=$folder/ctld.log
SlurmdLogFile=$folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
KillWait=1
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1
SlurmdParameters=config_overrides
NodeName=node[1-4] CPUs=2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=[$((port + 1))-$((port + 4))]
PartitionName=all Nodes=ALL Default=YES State=UP
END
export SLURM_CONF="$folder/slurm.conf"
munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munge.pid" \
  --log-file="$folder/munge.log" --seed-file="$folder/munge.seed" || skip "munged does not start"
slurmctld || skip "slurmctld does not start"
for node in 1 2 3 4; do slurmd -N "node$node" || skip "slurmd does not start"; done
tries=0
until [ "$(sinfo --noheader --states=idle --format=%D 2> sinfo.log)" = 4 ]; do
  tries=$((tries + 1))
  [ "$tries" -lt 600 ] || skip "Slurm has no four nodes after a minute: $(tail -n 2 ctld.log sinfo.log)"
  sleep 0.1
done

# submit ARGUMENT...: starts eight parts and prints the number of the job
submit() { sbatch --parsable --array=0-7 "$farm" "$@"; }

# wait_for COMMAND...: up to five minutes
wait_for() {
  tries=0
  until "$@"; do
    [ "$tries" -lt 1500 ] || {
      echo "timeout: $*"
      exit 1
    }
    tries=$((tries + 1))
    sleep 0.2
  done
}
is_idle() { [ -z "$(squeue --noheader)" ]; }

# same FILE FILE: compares all pixels
same() {
  sums=$(oiiotool --hash "$1" "$2" | sed -n 's/^.*SHA-1: *//p')
  [ "$(echo "$sums" | wc -l)" = 2 ] && [ "$(echo "$sums" | sort -u | wc -l)" = 1 ] || {
    echo "$1 and $2 differ: $sums"
    exit 1
  }
}

# --- a picture, and a node that is killed -------------------------------------------------------

"$render" --scene cube --level 4 --size 200x150 --save cube.cbvh --output built > render.log
"$render" --load cube.cbvh --size 200x150 --exr --output whole >> render.log
picture=$(basename whole/*.exr)
# The first run of part 3 stops before it renders.
set -- "$folder/picture" 8 200x150 sh -c \
  '[ "$1" != 3 ] || [ -e "$2" ] || { : > "$2"; sleep 600; }; shift 2; exec "$@"' sh '{part}' "$folder/stopped" \
  "$render" --load "$folder/cube.cbvh" --size 200x150 --crop '{crop}' --exr --output '{output}'
job=$(submit "$@")
wait_for test -e stopped
scancel --full --signal=KILL "${job}_3"
wait_for is_idle
[ ! -e picture/part-3 ] || exit 1
for part in 0 1 2 4 5 6 7; do [ -e "picture/part-$part/$picture" ] || exit 1; done
touch -d @1 picture/part-0/*
! "$farm" --join picture 8 200x150 "$picture" joined.exr 2> message || exit 1
grep "part-3/.* does not exist: part 3 is not finished" message

submit "$@"
wait_for is_idle
[ "$(stat -c %Y "picture/part-0/$picture")" = 1 ] || exit 1 # not rendered again
"$farm" --join picture 8 200x150 "$picture" joined.exr
same "whole/$picture" joined.exr

# --- a raster ----------------------------------------------------------------------

oiiotool --create 90x70 1 --noise:type=gaussian:mean=100:stddev=5 -d float -o heights.tif
set -- 8 90x70 "$terrain" "$folder/heights.tif" --cell 3 --threads 1 --crop '{crop}' --output '{output}/sky.tif'
"$terrain" heights.tif --cell 3 --output sky.tif > terrain.log
submit "$folder/slurm" "$@"
wait_for is_idle
seq 0 7 | parallel --will-cite --quote env FARM_PART={} "$farm" parallel "$@" > parallel.log
mpirun --allow-run-as-root --oversubscribe -n 8 "$farm" mpi "$@" > mpi.log
for scheduler in slurm parallel mpi; do
  "$farm" --join $scheduler 8 90x70 sky.tif $scheduler.tif
  same sky.tif $scheduler.tif
done

# --- errors ------------------------------------------------------------------------

fails() {
  expected=$1
  shift
  ! "$@" 2> message || exit 1
  grep "$expected" message
}
fails "number of the part is ''" env -u FARM_PART "$farm" errors 2 true
fails "number of the part is '2': expected 0 to 1" env FARM_PART=2 "$farm" errors 2 true
fails "number of the part is '01'" env FARM_PART=01 "$farm" errors 2 true
fails "PARTS is 'x'" env FARM_PART=0 "$farm" errors x true
fails "{crop} needs WIDTHxHEIGHT" env FARM_PART=0 "$farm" errors 2 echo '{crop}'
fails "part 0 failed with exit status 1" env FARM_PART=0 "$farm" errors 2 false
! FARM_PART=0 "$farm" errors 2 600 echo '{crop}' > message 2>&1 || exit 1 # a number is no size

# A signal stops the command.
FARM_PART=0 "$farm" errors 2 sh -c 'echo $$ > "$1"; exec sleep 600' sh "$folder/command" &
wait_for test -s command
kill "$!"
! wait "$!" || exit 1
! kill -0 "$(cat command)" 2> /dev/null || exit 1
[ -z "$(ls errors)" ] || exit 1 # nothing remains of failed parts
fails "the parts have 90 x 35 pixels: expected 90 x 70" "$farm" --join slurm 4 90x70 sky.tif wrong.tif
echo "eight parts by Slurm, parallel and MPI: equal"
