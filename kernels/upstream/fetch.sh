#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Downloads the source archive of upstream from the package registry that this
# machine is already set up to use, by its ordinary client.
#
#   fetch.sh PACKAGE VERSION DIRECTORY SUITE    leaves PACKAGE_VERSION.orig.tar.* in DIRECTORY
#
# SUITE is the release of Debian that has this version. On a machine with another
# release, the suite is looked up on the mirrors that the machine's own suites
# come from. The last line of the output says why a download failed.
#
# Nothing of the system's apt state is read or written but its configuration:
# the index of source packages, which most machines do not keep, goes into a
# state directory of our own that is removed at the end.
set -eu
package=$1 version=$2 directory=$3 suite=$4
command -v apt-get > /dev/null || { echo "this machine has no apt-get" >&2; exit 1; }

state=$(mktemp -d)
trap 'rm -rf "$state"' EXIT
trap 'exit 1' HUP INT TERM
mkdir -p "$state/lists/partial" "$state/cache/archives/partial" "$state/download"

# Our state directory in place of the system's; the sources are still the system's.
run() {
  timeout --kill-after=10 "${FETCH_TIMEOUT:-180}" "$@" -q \
    -o Dir::State="$state" -o Dir::State::Lists="$state/lists" -o Dir::State::Status=/dev/null \
    -o Dir::Cache="$state/cache" -o APT::Sandbox::User="$(id -un)" \
    -o Acquire::Languages=none -o Acquire::Retries=2 \
    -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20
}

# Every configured `deb` index of Debian's main component, whether it comes from
# a one-line or a deb822 source: address, release as configured, code name.
indices() {
  "$@" apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(CODENAME)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' | sort -u > "$state/indices"
  [ -s "$state/indices" ]
}
# apt lists only indices that it has: none on a machine whose lists were removed.
indices env || { run apt-get update >&2 && indices run; } ||
  { echo "apt on this machine has no source of Debian's main component" >&2; exit 1; }

# The places to look at, one after the other: the suite and its updates, if they
# are configured; otherwise the suite on each mirror, which security updates and
# backports (their names have a hyphen) are not.
# trusted=yes: the pinned SHA-256 decides what is accepted, so a machine whose
# keys are kept elsewhere than in apt's default place need not be told where.
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
    # The Debian revision may change with a rebuild, the upstream archive does not.
    full=$(source_index apt-cache showsrc "$package" | sed -n 's/^Version: //p' | grep -F "$version-" | sort -uV | tail -n 1)
    [ -n "$full" ] || continue
    (cd "$state/download" && source_index apt-get source --download-only --tar-only "$package=$full") && return 0
  done
  echo "suite $suite of this machine's mirror of Debian does not answer, or lacks source package $package $version"
  return 1
}
attempt >&2 || { echo "first attempt failed, trying once more" >&2; sleep 3; attempt >&2; }

mv "$state/download/${package}_$version".orig.tar.* "$directory/"
