# shellcheck shell=sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# For the scripts in this folder: installs pinned packages of Debian into a temporary folder, $root, which is removed at
# the end. Nothing outside of it changes, and nothing of this project is used. Source this file; do not run it.

set -eu
here=$(cd -- "$(dirname -- "$0")" && pwd)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
apt=$root/apt
. "$here/../scripts/private_apt.sh"

# install_pinned SUITE PACKAGE=VERSION...: with all packages that they depend on
install_pinned() {
  suite=$1
  shift
  {
    private_apt_update "$(dpkg --print-architecture)" "$suite" 'Codename: bookworm'
    private_apt apt-get install -y --no-install-recommends --download-only "$@"
  } > "$root/apt.log" 2>&1 || {
    tail -n 5 "$root/apt.log" >&2
    echo "not tried: $* cannot be installed" >&2
    exit 77
  }
  for package in "$apt"/cache/archives/*.deb; do
    dpkg -x "$package" "$root/system"
  done
}

# in_root COMMAND ARGUMENT...: runs an installed command with the installed libraries
in_root() {
  command=$1
  shift
  libraries=$root/system/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH 2> /dev/null || gcc -print-multiarch)
  loader=$(find "$root/system" -name 'ld-linux-*.so.*' | head -n 1)
  "$loader" --library-path "$libraries:$(dirname "$loader"):$libraries/blas:$libraries/lapack" \
    "$root/system/usr/bin/$command" "$@"
}

# observe WHAT EXPECTED SEEN: fails if the behavior that this script documents changed
observe() {
  echo "$1: $3"
  [ "$2" = "$3" ] || {
    echo "changed: expected $2" >&2
    exit 1
  }
}
