#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that kernels/upstream/fetch.sh finds the pinned source package on machines of the pinned release and of
# others, with sources in one line or as deb822, and prints the reason in its last line if it finds none. A mirror in
# a folder replaces the machine's, so that no network is needed.
#
#   fetch.sh FETCH-SCRIPT
set -eu
fetch=$1
command -v apt-get > /dev/null || {
  echo "skipped: no apt-get"
  exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# suite MIRROR SUITE ORIGIN [VERSION]: creates an index of one program, and of the source package `thing` in this
# version
suite() {
  folder=$work/$1/dists/$2
  mkdir -p "$folder/main/binary-all" "$folder/main/source" "$work/$1/pool"
  printf 'Package: program\nVersion: 1\nArchitecture: all\nSize: 1\nFilename: pool/program.deb\n\n' \
    > "$folder/main/binary-all/Packages"
  for architecture in $(dpkg --print-architecture); do
    mkdir -p "$folder/main/binary-$architecture"
    cp "$folder/main/binary-all/Packages" "$folder/main/binary-$architecture/"
  done
  : > "$folder/main/source/Sources"
  if [ -n "${4:-}" ]; then
    name=thing_$4
    echo "archive of $2" > "$work/$1/pool/$name.orig.tar.xz"
    echo "description" > "$work/$1/pool/$name-1.dsc"
    {
      printf '%s\n' 'Package: thing' 'Binary: program' "Version: $4-1" 'Architecture: all' 'Format: 3.0 (quilt)' \
        'Directory: pool'
      for kind in Files:md5sum Checksums-Sha256:sha256sum; do
        echo "${kind%:*}:"
        for file in "$name-1.dsc" "$name.orig.tar.xz"; do
          path=$work/$1/pool/$file
          echo " $(${kind#*:} "$path" | cut -d ' ' -f 1) $(wc -c < "$path") $file"
        done
      done
      echo
    } > "$folder/main/source/Sources"
  fi
  {
    printf 'Origin: %s\nSuite: %s\nCodename: %s\nComponents: main\nArchitectures: all %s\n' "$3" "$2" "$2" \
      "$(dpkg --print-architecture)"
    printf 'Date: %s\nSHA256:\n' "$(LC_ALL=C date -u '+%a, %d %b %Y %H:%M:%S UTC')"
    (cd "$folder" && find main -type f | while read -r file; do
      echo " $(sha256sum "$file" | cut -d ' ' -f 1) $(wc -c < "$file") $file"
    done)
  } > "$folder/Release"
}

# machine NAME: creates a folder of sources and of apt's state that replaces the machine's
machine() {
  name=$1
  mkdir -p "$work/$name/sources" "$work/$name/state/lists/partial" "$work/$name/cache/archives/partial"
  cat > "$work/$name/apt.conf" << CONF
Dir::Etc::SourceList "/dev/null";
Dir::Etc::SourceParts "$work/$name/sources";
Dir::State "$work/$name/state";
Dir::State::Lists "$work/$name/state/lists";
Dir::Cache "$work/$name/cache";
CONF
}
line() { echo "deb [trusted=yes] file:$work/$1/ $2 main" >> "$work/$name/sources/one.list"; }

# get: runs fetch.sh with the sources of the current machine
get() {
  rm -rf "$work/got"
  mkdir "$work/got"
  APT_CONFIG=$work/$name/apt.conf sh "$fetch" thing 3.1+dfsg "$work/got" old > "$work/log" 2>&1
}
finds() {
  get || {
    cat "$work/log"
    fail "$name: nothing was found"
  }
  [ "$(cat "$work/got/thing_3.1+dfsg.orig.tar.xz")" = "archive of $1" ] || fail "$name: this is not the archive of $1"
  echo "$name: found"
}
refuses() {
  ! get || fail "$name: something was found"
  tail -n 1 "$work/log" | grep -q "$1" || {
    cat "$work/log"
    fail "$name: the last line lacks: $1"
  }
  [ -z "$(ls "$work/got")" ] || fail "$name: files were left"
  echo "$name: $(tail -n 1 "$work/log")"
}

suite mirror old Debian 3.1+dfsg
suite mirror new Debian 4.3+dfsg
suite mirror old-security Debian
suite mirror new-security Debian
suite young new Debian 4.3+dfsg
suite other new Ubuntu 4.3+dfsg

machine "the pinned release"
line mirror old
line mirror old-security
finds old

machine "another release, in one line"
line mirror new
line mirror new-security
finds old

machine "another release, as deb822"
printf 'Types: deb\nURIs: file:%s/mirror/\nSuites: new new-security\nComponents: main\nTrusted: yes\n' "$work" \
  > "$work/$name/sources/debian.sources"
finds old

machine "two mirrors, the first without the pinned release"
line young new
line mirror new
finds old

machine "the pinned release next to another"
line young new
line mirror old
finds old

machine "a mirror without the pinned release"
line young new
refuses "suite old .*Debian.*thing 3.1+dfsg"

machine "another distribution"
line other new
refuses "Debian.*main"

name="without apt"
mkdir "$work/bin"
ln -s "$(command -v sh)" "$work/bin/sh"
PATH=$work/bin sh "$fetch" thing 3.1+dfsg "$work/got" old > "$work/log" 2>&1 && fail "$name: something was found"
grep -q "no apt-get" "$work/log" ||
  {
    cat "$work/log"
    fail "$name: the message does not contain the reason"
  }
echo passed
