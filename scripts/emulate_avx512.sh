#!/usr/bin/env bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Runs programs of a build in the emulator Bochs, whose processor supports AVX-512, on a machine whose processor does
# not.
#
#   emulate_avx512.sh [options] BUILD COMMAND...
#
# BUILD is a build folder. Each COMMAND is one argument: a program, relative to BUILD or absolute, and its arguments
# separated by blanks, without quotes:
#   emulate_avx512.sh build/release tests/isa/test_simd_decoding_avx512 \
#     'tests/library/test_scene_features --gtest_filter=*Packets*'
#
#   -o FOLDER   folder of the image and the logs (default: a new one in /tmp)
#   -f PATH     a file or folder that the programs read, absolute; it has the same
#               path in the emulator (may be repeated)
#   -t SECONDS  stops Bochs after this time (default: 3600)
#   -c MODEL    Bochs's processor (default: corei7_skylake_x)
#   -m MIB      memory (default: depends on the size of the programs, at least 1024)
#   -k KERNEL   a Linux kernel (default: the newest in /boot)
#
# Stripped copies of the programs, their shared libraries and busybox become an initramfs. Kernel and initramfs become
# a CD that ISOLINUX boots. The emulator's serial port is the file FOLDER/serial.log, which receives all output of the
# programs. The programs run one after the other on one processor of 25 million instructions per second. The emulated
# clock is that of a 3.5 GHz machine: each of its seconds takes two to three minutes. For each program the script
# prints a line "== N exit CODE".
#
# Exit code: 0 if every program returned 0, 1 otherwise, 2 if the emulation failed. Programs that use OpenImageIO load
# 300 MB of libraries, which may not fit into memory.
#
# Requires the Debian packages bochs, bochs-term, busybox-static, cpio, isolinux, syslinux-common, xorriso and a
# kernel such as linux-image-cloud-amd64.
set -euo pipefail

usage() {
  sed -n '5,/^set /{/^set /d;s/^# \{0,1\}//;p}' "$0"
  exit "$1"
}

fail() {
  echo "emulate_avx512: $*" >&2
  exit 2
}

out=
limit=3600
model=corei7_skylake_x
memory=
kernel=
extra=()
[[ ${1:-} != --help ]] || usage 0
while getopts 'o:f:t:c:m:k:h' option; do
  case $option in
    o) out=$OPTARG ;;
    f) extra+=("$OPTARG") ;;
    t) limit=$OPTARG ;;
    c) model=$OPTARG ;;
    m) memory=$OPTARG ;;
    k) kernel=$OPTARG ;;
    h) usage 0 ;;
    *) usage 2 >&2 ;;
  esac
done
shift $((OPTIND - 1))
(($# >= 2)) || usage 2 >&2
build=$(realpath "$1")
shift

for program in bochs busybox cpio ldd stty strip xorriso; do
  command -v "$program" > /dev/null || fail "$program is missing"
done
if [[ -z $kernel ]]; then
  kernel=$(find /boot -name 'vmlinuz-*' | sort -V | tail -n 1)
fi
[[ -r $kernel ]] || fail "no kernel in /boot; install linux-image-cloud-amd64"
isolinux=/usr/lib/ISOLINUX/isolinux.bin
ldlinux=/usr/lib/syslinux/modules/bios/ldlinux.c32
[[ -r $isolinux && -r $ldlinux ]] ||
  fail "isolinux or syslinux-common is missing"

out=${out:-$(mktemp -d /tmp/avx512.XXXXXX)}
mkdir -p "$out"
out=$(realpath "$out")
root=$out/root
rm -rf "$root" "$out/cd" "$out/serial.log"
mkdir -p "$root"/{bin,dev,proc,sys,tmp} "$out/cd"

# Writes a stripped copy of a file to the same path below $root.
copy_stripped() {
  local target=$root$1
  [[ -e $target ]] && return
  mkdir -p "$(dirname "$target")"
  strip -s -o "$target" "$(realpath "$1")" 2> /dev/null ||
    cp -L "$1" "$target"
  chmod 755 "$target"
}

copy_program() {
  local libraries library
  copy_stripped "$1"
  libraries=$(ldd "$1" 2> /dev/null || true) # static programs have no libraries
  [[ $libraries != *'not found'* ]] || fail "$1 lacks libraries: $libraries"
  while read -r library; do
    copy_stripped "$library"
  done < <(grep -o '/[^ ]*' <<< "$libraries" || true)
}

cp "$(command -v busybox)" "$root/bin/busybox"
for path in "${extra[@]}"; do
  mkdir -p "$root$(dirname "$path")"
  cp -rL "$path" "$root$path"
done

# Each command becomes one line of /commands, which /init reads.
for command in "$@"; do
  [[ $command == /* ]] || command=$build/$command
  program=${command%% *}
  [[ -x $program ]] || fail "no program $program"
  copy_program "$program"
  echo "$command" >> "$root/commands"
done

# LD_BIND_NOW: glibc's lazy resolver saves registers with XSAVEC and restores them with XRSTOR, for which Bochs 2.7
# raises a general protection fault.
cat > "$root/init" << 'INIT'
#!/bin/busybox sh
/bin/busybox --install -s /bin
export PATH=/bin HOME=/tmp GTEST_COLOR=no LD_BIND_NOW=1
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev 2> /dev/null
flags=$(grep -m 1 '^flags' /proc/cpuinfo | tr ' ' '\n' | grep '^avx' | tr '\n' ' ')
echo "== processor: $(grep -m 1 'model name' /proc/cpuinfo | cut -d : -f 2) with $flags"
case $flags in *avx512f*) ;; *) echo '== no AVX-512' ;; esac
cd /tmp
set -f
number=0
while read -r command <&3; do
  number=$((number + 1))
  start=$(cut -d . -f 1 /proc/uptime)
  echo "== $number begin $command"
  $command < /dev/null 2>&1 3<&-
  code=$?
  echo "== $number exit $code after $(($(cut -d . -f 1 /proc/uptime) - start)) s of the emulated clock"
done 3< /commands
echo '== all done'
sleep 1 # until the serial port has sent all output
poweroff -f
INIT
chmod 755 "$root/init"

(cd "$root" && find . | cpio --quiet -o -H newc -R 0:0) > "$out/cd/initrd"
size=$(($(stat -c %s "$out/cd/initrd") / 1048576))
# The archive and its unpacked files exist at the same time, the latter in a file system of at most half the memory.
least=$((3 * size + 512))
memory=${memory:-$((least < 1024 ? 1024 : least))}
((memory <= 2048)) || fail "$size MiB of programs do not fit into 2 GiB"

# Bochs reports a size of the XSAVES and XSAVEC areas that Linux considers an error. Linux would then disable AVX, so
# these two features (bits 323 and 321) are turned off.
cp "$kernel" "$out/cd/linux"
cp "$isolinux" "$ldlinux" "$out/cd/"
parameters="console=ttyS0,115200 quiet panic=-1 nokaslr nosmp mitigations=off tsc=reliable clocksource=tsc"
parameters="$parameters random.trust_cpu=on noxsaves clearcpuid=321,323"
cat > "$out/cd/isolinux.cfg" << CFG
DEFAULT linux
PROMPT 0
LABEL linux
  KERNEL linux
  INITRD initrd
  APPEND $parameters
CFG
xorriso -as mkisofs -o "$out/cd.iso" -b isolinux.bin -c boot.cat -no-emul-boot \
  -boot-load-size 4 -boot-info-table "$out/cd" > "$out/xorriso.log" 2>&1 ||
  fail "cannot create the CD; see $out/xorriso.log"

cat > "$out/bochsrc" << RC
config_interface: textconfig
display_library: term
cpu: model=$model, count=1, ips=50000000, reset_on_triple_fault=0
memory: guest=$memory, host=$memory
romimage: file=/usr/share/bochs/BIOS-bochs-latest
vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path="$out/cd.iso", status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev="$out/serial.log"
speaker: enabled=0
clock: sync=none
log: $out/bochs.log
panic: action=fatal
error: action=report
info: action=ignore
RC
# Debian's Bochs starts in its debugger; "c" continues.
echo c > "$out/debugger"

echo "emulate_avx512: $# program(s), $size MiB; they print to $out/serial.log"
start=$SECONDS
TERM=xterm timeout -k 10 "$limit" nice -n 5 \
  bochs -q -f "$out/bochsrc" -rc "$out/debugger" \
  > "$out/bochs.out" 2>&1 < /dev/null &
bochs=$!
reader=
trap 'kill $bochs $reader 2> /dev/null || true' EXIT
# The only displays of Debian's Bochs are windows, VNC and terminals. It opens a terminal of its own and blocks once
# the terminal's buffer is full, so a process must read from it.
while [[ -z $reader ]] && kill -0 "$bochs" 2> /dev/null; do
  sleep 0.2
  screen=$(sed -n 's/.*connected to screen "\(.*\)".*/\1/p' "$out/bochs.out")
  if [[ -n $screen ]]; then
    stty -F "$screen" raw -echo
    cat "$screen" > /dev/null 2>&1 &
    reader=$!
  fi
done
wait "$bochs" || true # powering off also counts as an error
echo "emulate_avx512: Bochs ran for $((SECONDS - start)) s"

touch "$out/serial.log"
tr -d '\r' < "$out/serial.log" | grep -aE '^== |^\[ *(PASSED|FAILED|SKIPPED)' || true
if ! grep -qa '^== all done' "$out/serial.log"; then
  tail -n 20 "$out/serial.log" >&2
  fail "the emulation did not finish; see $out/serial.log and bochs.log"
fi
if grep -qaE '^== [0-9]+ exit [1-9]|^== no AVX-512' "$out/serial.log"; then
  exit 1
fi
