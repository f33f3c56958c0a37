# shellcheck shell=sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# What the commands of this directory share; sourced, not run.

set -eu
root=$(cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
jobs=$(nproc)
summary=

# phase NAME COMMAND...: runs the command, notes how long it took. `set -e` does
# not reach into a function that runs here.
phase() {
  name=$1; shift
  echo "== $name"
  start=$(date +%s)
  failed=0
  "$@" || failed=$?
  took=$(($(date +%s) - start))
  total=$((${total:-0} + took))
  summary="$summary$(printf '  %-28s %5d s' "$name" "$took")
"
  [ "$failed" = 0 ] || { echo "$name failed" >&2; exit "$failed"; }
}

# Where the time went, also when a phase fails.
print_summary() {
  printf '== time\n%s  %-28s %5d s\n' "$summary" total "${total:-0}"
}
trap print_summary EXIT

# Installs the packages of scripts/packages that are missing, but none whose place an installed package
# takes, as ours take that of Debian's Embree: to install them would remove it.
install_packages() {
  missing=
  present=" $(dpkg-query -W -f '${db:Status-Status} ${Package}, ${Provides}\n' | sed -n 's/^installed //p' |
    tr ',' '\n' | sed 's/^ *//; s/[ :].*//' | tr '\n' ' ') "
  for package in $(sed 's/#.*//' scripts/packages); do
    case $present in
      *" $package "*) ;;
      *) missing="$missing $package" ;;
    esac
  done
  [ -n "$missing" ] || { echo "every package is present"; return 0; }
  echo "installing$missing"
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=600 update || return
  # shellcheck disable=SC2086
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=600 -o Dpkg::Use-Pty=0 \
    install --no-install-recommends $missing
}

configure() {
  cmake --preset release ${EMBREE_UPSTREAM_ARCHIVE:+"-DEMBREE_UPSTREAM_ARCHIVE=$EMBREE_UPSTREAM_ARCHIVE"}
}

# build [TARGET...]
build() {
  cmake --build --preset release -j "$jobs" ${1:+--target "$@"}
}
