#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Downloads the source archive of upstream from the package registry that this
# machine is already set up to use, by its ordinary client.
#
#   fetch.sh PACKAGE VERSION DIRECTORY    leaves PACKAGE_VERSION.orig.tar.* there
#
# Nothing of the system's apt state is read or written but its configuration:
# the index of source packages, which most machines do not keep, goes into a
# state directory of our own that is removed at the end.
set -eu
package=$1 version=$2 directory=$3

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

# Every configured `deb` index of Debian's main component, as `deb-src`.
# trusted=yes: the pinned SHA-256 decides what is accepted, so a machine whose
# keys are kept elsewhere than in apt's default place need not be told where.
entries() {
  "$@" apt-get indextargets --format 'deb-src [trusted=yes] $(REPO_URI) $(RELEASE) $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' | sort -u > "$state/sources.list"
  [ -s "$state/sources.list" ]
}
# apt lists only indices that it has: none on a machine whose lists were removed.
entries env || { run apt-get update >&2 && entries run; } ||
  { echo "no apt source of Debian's main component" >&2; exit 1; }

source_index() {
  run "$@" -o Dir::Etc::SourceList="$state/sources.list" -o Dir::Etc::SourceParts=/dev/null
}

attempt() {
  source_index apt-get update --error-on=any || return 1
  # The Debian revision may change with a rebuild, the upstream archive does not.
  full=$(source_index apt-cache showsrc "$package" | sed -n 's/^Version: //p' | grep -F "$version-" | sort -uV | tail -n 1)
  [ -n "$full" ] || { echo "the registry has no source package $package $version" >&2; return 1; }
  (cd "$state/download" && source_index apt-get source --download-only --tar-only "$package=$full")
}
attempt >&2 || { echo "first attempt failed, trying once more" >&2; sleep 3; attempt >&2; }

mv "$state/download/${package}_$version".orig.tar.* "$directory/"
