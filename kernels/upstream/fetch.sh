#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Downloads the source archive of upstream with apt.
#
#   fetch.sh PACKAGE VERSION DIRECTORY SUITE    writes PACKAGE_VERSION.orig.tar.* to DIRECTORY
#
# SUITE is the Debian release that contains this version. If the machine uses another release, the script searches for
# SUITE on the mirrors of the machine's own suites. If it fails, the last line of the output is the reason.
#
# The script does not change the state of apt. It uses a temporary state directory, because most machines do not keep
# the index of source packages.
set -eu
package=$1 version=$2 directory=$3 suite=$4
command -v apt-get > /dev/null || {
  echo "this machine has no apt-get" >&2
  exit 1
}

state=$(mktemp -d)
trap 'rm -rf "$state"' EXIT
trap 'exit 1' HUP INT TERM
mkdir -p "$state/lists/partial" "$state/cache/archives/partial" "$state/download"

# Runs apt with our state directory and the system's sources.
run() {
  timeout --kill-after=10 "${FETCH_TIMEOUT:-180}" "$@" -q \
    -o Dir::State="$state" -o Dir::State::Lists="$state/lists" -o Dir::State::Status=/dev/null \
    -o Dir::Cache="$state/cache" -o APT::Sandbox::User="$(id -un)" \
    -o Acquire::Languages=none -o Acquire::Retries=2 \
    -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20
}

# Writes one line per configured `deb` index of Debian's main component: address, release as configured, code name.
indices() {
  "$@" apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(CODENAME)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' | sort -u > "$state/indices"
  [ -s "$state/indices" ]
}
# apt lists only downloaded indices. If there are none, download them.
indices env || { run apt-get update >&2 && indices run; } ||
  {
    echo "apt on this machine has no source of Debian's main component" >&2
    exit 1
  }

# Sources to try, one after another: the suite and its updates if they are configured, otherwise the suite on each
# mirror. Mirrors of security updates and backports, which have a hyphen in their names, do not contain it.
# trusted=yes: apt's keys may not be in the default folder, and the pinned SHA-256 decides which archive is accepted.
awk -v suite="$suite" -v state="$state" '
  $3 == suite || index($3, suite "-") == 1 { print "deb-src [trusted=yes]", $1, $2, "main" > (state "/place.0"); next }
  $2 !~ /-/ && !($1 in seen) { seen[$1]; print "deb-src [trusted=yes]", $1, suite, "main" > (state "/place." ++places) }
' "$state/indices"
[ ! -e "$state/place.0" ] || rm -f "$state"/place.[1-9]*

source_index() {
  run "$@" -o Dir::Etc::SourceList="$place" -o Dir::Etc::SourceParts=/dev/null
}

attempt() {
  for place in "$state"/place.*; do
    source_index apt-get update --error-on=any || continue
    # A rebuild may change the Debian revision but not the upstream archive.
    full=$(source_index apt-cache showsrc "$package" | sed -n 's/^Version: //p' | grep -F "$version-" | sort -uV |
      tail -n 1)
    [ -n "$full" ] || continue
    (cd "$state/download" && source_index apt-get source --download-only --tar-only "$package=$full") && return 0
  done
  echo "suite $suite of this machine's mirror of Debian does not answer, or lacks source package $package $version"
  return 1
}
attempt >&2 || {
  echo "first attempt failed, trying once more" >&2
  sleep 3
  attempt >&2
}

mv "$state/download/${package}_$version".orig.tar.* "$directory/"
