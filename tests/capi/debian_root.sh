# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions for scripts that run programs on another release of Debian. Source it with $roots set to a folder, and
# $release to trixie, testing or unstable: it makes a root file system there if none exists, and sets $root to its path.
# This requires root, debootstrap and a registry of Debian packages. If $roots is empty, it only defines fail(), for
# scripts that test on this machine instead.

export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
[ -n "$roots" ] || return 0

mkdir -p "$roots"
root=$(cd "$roots" && pwd)/$release
if [ ! -d "$root" ]; then
  mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 'Origin: Debian' 'Component: main' |
    sort -u | head -n 1)
  debootstrap --variant=minbase "$release" "$root.part" "$mirror" > "$roots/log" ||
    {
      tail "$roots/log"
      fail "debootstrap cannot make $root.part"
    }
  cp /etc/resolv.conf "$root.part/etc/"
  # A registry may have an old copy of a release that changes daily.
  [ "$release" = trixie ] ||
    echo 'Acquire::Check-Valid-Until "false";' > "$root.part/etc/apt/apt.conf.d/90old-copy"
  chroot "$root.part" apt-get -q update > "$roots/log" 2>&1 ||
    {
      tail "$roots/log"
      fail "apt-get update in $root.part"
    }
  mv "$root.part" "$root"
fi

# install_in_root PACKAGE...: installs the packages that are missing in $root
install_in_root() {
  for package in "$@"; do
    chroot "$root" dpkg-query -W -f '${Status}' "$package" 2> /dev/null | grep -q 'ok installed' && continue
    chroot "$root" apt-get -q -y --no-install-recommends install "$@" > "$roots/log" 2>&1 ||
      {
        tail "$roots/log"
        fail "apt-get install in $root: $*"
      }
    return
  done
}
