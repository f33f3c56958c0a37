#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Runs a command on a clean Debian, in a separate root file system that is independent of this machine's packages.
#
#   scripts/roots.sh debian12|debian13|debian14|unstable [COMPILER] [-- COMMAND [ARGUMENT...]]
#
# debian14 is Debian's testing release until Debian 14 is released.
# COMPILER is gcc (default), clang, or a version that the release provides, such as gcc-13 or clang-19. COMMAND is
# scripts/demo.sh by default. It runs as root in a clone of the committed state, with CC and CXX set.
#
# If the root file system does not exist, debootstrap creates it in build/roots/NAME from the mirror of this machine's
# apt. CBVH_ROOTS replaces build/roots; DEBIAN_MIRROR replaces the mirror. It is kept with its packages, and with one
# clone and build per compiler. An archive of Embree's source in ../shared/upstream, or of an earlier build here, is the
# fallback if the package registry does not answer. Requires root, debootstrap, git, and 1 GB of disk; 6 GB for
# scripts/test.sh.

distribution=${1:-}
[ "$#" = 0 ] || shift
compiler=gcc
case ${1:-} in
  '' | --) ;;
  *)
    compiler=$1
    shift
    ;;
esac
unexpected=
[ "${1:---}" = -- ] || unexpected=$1
[ "$#" = 0 ] || shift

# Options of COMMAND are passed on.
arguments=2
load() { . "$(dirname -- "$0")/lib.sh"; }
load "$distribution" "$compiler"
[ -z "$unexpected" ] || usage_error "$unexpected: expected -- before a command"
[ "$#" -gt 0 ] || set -- scripts/demo.sh

case $distribution in
  debian12) suite=bookworm ;;
  debian13) suite=trixie ;;
  debian14) suite=testing ;;
  unstable) suite=unstable ;;
  *) usage_error "unknown distribution \"$distribution\": expected debian12, debian13, debian14 or unstable" ;;
esac
case $compiler in
  gcc | gcc-[0-9]*) cxx=g++${compiler#gcc} ;;
  clang | clang-[0-9]*) cxx=clang++${compiler#clang} ;;
  *) usage_error "\"$compiler\" is not a compiler: expected gcc, clang, gcc-VERSION or clang-VERSION" ;;
esac
[ "$(id -u)" = 0 ] || usage_error "only root can create and enter a root file system"
command -v debootstrap > /dev/null || usage_error "debootstrap is missing: install the package debootstrap"

roots=${CBVH_ROOTS:-build/roots}
mkdir -p "$roots"
roots=$(cd -- "$roots" && pwd)
base=$roots/$distribution
home=/root/$compiler # one clone per compiler, because a build folder keeps its compiler

make_root() {
  if [ -d "$base" ]; then
    echo "$base is present"
    return
  fi
  # On Debian, apt knows a mirror. Its security updates are on another server.
  mirror=${DEBIAN_MIRROR:-$(apt-get indextargets --format '$(RELEASE) $(SITE)' 'Created-By: Packages' 'Origin: Debian' \
    'Component: main' | sed -n '/^[^ ]*-/!s/^[^ ]* //p' | sort -u | head -n 1)}
  [ -n "$mirror" ] ||
    {
      echo "apt has no source of Debian's main component: set DEBIAN_MIRROR to a mirror" >&2
      return 1
    }
  rm -rf --one-file-system "$base.part"
  debootstrap --variant=minbase --include=ca-certificates "$suite" "$base.part" "$mirror" \
    > "$roots/$distribution.log" ||
    {
      tail "$roots/$distribution.log" >&2
      return 1
    }
  cp -L /etc/resolv.conf "$base.part/etc/"
  apt-config dump | grep -E '^Acquire::[a-z]+::Proxy' > "$base.part/etc/apt/apt.conf.d/90proxy" || true
  # A mirror may have an old copy of a release that changes daily.
  case $suite in
    testing | unstable) echo 'Acquire::Check-Valid-Until "false";' > "$base.part/etc/apt/apt.conf.d/90old-copy" ;;
  esac
  mv "$base.part" "$base"
}

# inside COMMAND...: runs a command in the root without this machine's environment. Its mounts end with it.
inside() {
  unshare --mount sh -euc '
    base=$1; shift
    mount --rbind /proc "$base/proc"
    mount --rbind /dev "$base/dev"
    exec chroot "$base" env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      LANG=C.UTF-8 TERM="${TERM:-dumb}" DEBIAN_FRONTEND=noninteractive "$@"' sh "$base" "$@"
}

get_compiler() {
  case $compiler in gcc*) package=$cxx ;; *) package=$compiler ;; esac
  if inside sh -c "command -v $compiler && command -v $cxx" > /dev/null; then
    echo "$compiler is present"
    return
  fi
  inside apt-get -q update && inside apt-get -q -y -o Dpkg::Use-Pty=0 install --no-install-recommends "$package"
}

get_sources() {
  clone=$base$home/embree-cbvh
  mkdir -p "$base$home"
  if [ ! -d "$clone" ]; then
    git clone -q --no-hardlinks "$root" "$clone"
  else # keeps earlier builds
    git -C "$clone" fetch -q "$root" HEAD && git -C "$clone" reset -q --hard FETCH_HEAD
  fi || return
  git -C "$clone" log -1 --format='%h %s'
  for archive in "$root"/../shared/upstream/embree_*.orig.tar.xz "$root"/.upstream/embree_*.orig.tar.xz; do
    [ -e "$archive" ] || continue
    mkdir -p "$base$home/shared/upstream"
    cp "$archive" "$base$home/shared/upstream/"
    fallback=$home/shared/upstream/${archive##*/}
  done
}

run_command() {
  inside ${fallback:+"EMBREE_UPSTREAM_FALLBACK=$fallback"} CC="$compiler" CXX="$cxx" \
    sh -c 'cd "$1" && shift && exec "$@"' sh "$home/embree-cbvh" "$@"
}

phase "root of $distribution" make_root
phase "compiler $compiler" get_compiler
phase "sources" get_sources
phase "$*" run_command "$@"
