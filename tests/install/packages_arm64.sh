#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks our Debian packages for ARM64 on x86-64:
#
#   - each program and library in them is for ARM64;
#   - apt installs them on an empty Debian for ARM64, in a simulation, with Debian's packages as dependencies;
#   - in the emulator, programs of the packages start, and cbvh_render and the Python module trace rays.
#
# Requires the package registry of a Debian, qemu-aarch64-static, and a folder made by scripts/arm64_root.sh. Unpacks
# the packages over a copy of this folder, which is made of hard links next to it.
#
#   packages_arm64.sh DIRECTORY-OF-PACKAGES FOLDER-OF-ARM64-ROOT
set -eu
packages=$(cd "$1" && pwd) root=$(cd "$2" && pwd)
cd -- "$(dirname -- "$0")/../.."
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
work=$(mktemp -d "$root.packages-XXXXXX") # on the same file system, for hard links
trap 'rm -rf "$work"' EXIT

# --- files ------------------------------------------------------------------------------------------

copy=$work/root
cp -al "$root" "$copy"
rm -f "$copy"/usr/lib/aarch64-linux-gnu/libembree3.so* # Debian's, which the packages replace
for package in "$packages"/*.deb; do
  [ "$(dpkg-deb -f "$package" Architecture)" = arm64 ] || fail "$package: the architecture is not arm64"
  dpkg-deb -x "$package" "$work/files"
  # tar replaces hard links, it does not write through them.
  dpkg-deb --fsys-tarfile "$package" | tar -x --keep-directory-symlink -f - -C "$copy"
done
find "$work/files" -type f -exec file {} + | grep ELF > "$work/elf"
! grep -v "ARM aarch64" "$work/elf" || fail "these files are for another processor: expected ARM aarch64"
echo "$(wc -l < "$work/elf") programs and libraries are for ARM64"

# --- dependencies -----------------------------------------------------------------------------------

apt=$work/apt
. scripts/private_apt.sh
{
  private_apt_update arm64 '$(RELEASE)' 'Component: main' &&
    private_apt apt-get install -y --simulate --no-install-recommends "$packages"/*.deb
} > "$work/log" 2>&1 ||
  {
    tail -n 30 "$work/log"
    fail "apt does not install the packages"
  }
! grep -E '^Inst (libembree3-3|libembree-dev|embree-tools) ' "$work/log" ||
  fail "apt installs a package of Debian that ours replace"
echo "apt installs the packages and $(($(grep -c '^Inst' "$work/log") - $(ls "$packages"/*.deb | wc -l))) of Debian's"

# --- in the emulator ----------------------------------------------------------------------------------

run() {
  program=$1
  shift
  qemu-aarch64-static -L "$copy" "$copy/usr/bin/$program" "$@"
}
version=$(dpkg-deb -f "$packages"/libembree3-cbvh_*.deb Version)
for program in cbvh_render cbvh_bench cbvh_pathtracer; do
  run $program --version > "$work/output" || fail "$program --version: status $?"
  grep -q "^$program $version" "$work/output" ||
    {
      cat "$work/output"
      fail "$program has another version: expected $version"
    }
  grep -q "^library: Embree CBVH $version on" "$work/output" ||
    {
      cat "$work/output"
      fail "$program loads another library: expected Embree CBVH $version"
    }
done
run cbvh_render --scene cube --level 3 --size 32x32 --representation cvert --output "$work/pictures" \
  > "$work/output" 2>&1 ||
  {
    cat "$work/output"
    fail "cbvh_render does not run"
  }
[ -s "$work/pictures/cube_cvert.png" ] || {
  cat "$work/output"
  fail "cbvh_render writes no picture"
}
run python3 -B -c "import embree_cbvh as cbvh
scene = cbvh.build(cbvh.Model.generate('cube'), 'cvert', 3)
hits = scene.intersect([0, 0, 5], [0, 0, -1])
assert hits.hit.all() and 0 < hits.t < 5, hits.t
print('Python module', cbvh.__version__, cbvh.__file__, 'hits at', hits.t)" ||
  fail "the Python module does not run, or its ray does not hit the cube"
echo "programs and the Python module run"
