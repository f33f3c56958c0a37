# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions for scripts that run programs on Debian 13. Source it with $roots set to a folder; $root is then the root
# file system in it. If $roots is empty, programs run on this machine, and only fail() is defined.

export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
fail() { echo "FAILED: $*" >&2; exit 1; }
[ -n "$roots" ] || return 0

mkdir -p "$roots"
root=$(cd "$roots" && pwd)/trixie
if [ ! -d "$root" ]; then
  mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 'Origin: Debian' 'Component: main' |
    sort -u | head -n 1)
  debootstrap --variant=minbase trixie "$root.part" "$mirror" > "$roots/log" ||
    { tail "$roots/log"; fail "debootstrap"; }
  cp /etc/resolv.conf "$root.part/etc/"
  chroot "$root.part" apt-get -q update > "$roots/log" 2>&1 || { tail "$roots/log"; fail "packages of Debian 13"; }
  mv "$root.part" "$root"
fi

# Installs missing packages.
with_packages()
{
  for package in "$@"; do
    chroot "$root" dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' && continue
    chroot "$root" apt-get -q -y --no-install-recommends install "$@" > "$roots/log" 2>&1 ||
      { tail "$roots/log"; fail "packages of Debian 13"; }
    return
  done
}
