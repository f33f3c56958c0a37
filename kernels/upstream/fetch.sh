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

# Every configured `deb` index of Debian's main component, as `deb-src`.
# trusted=yes: the pinned SHA-256 decides what is accepted, so a machine whose
# keys are kept elsewhere than in apt's default place need not be told where.
entries() {
  apt-get indextargets --format "$1deb-src [trusted=yes] \$(REPO_URI) \$(RELEASE) \$(COMPONENT)" \
    'Created-By: Packages' | sort -u | grep ' main$' || true
}
# The origin is known only where the indices have been downloaded before.
entries '$(ORIGIN)|' | sed -n 's/^Debian|//p' > "$state/sources.list"
[ -s "$state/sources.list" ] || entries '' > "$state/sources.list"
[ -s "$state/sources.list" ] || { echo "no apt source with a main component is configured" >&2; exit 1; }

apt() {
  tool=$1; shift
  timeout --kill-after=10 "${FETCH_TIMEOUT:-180}" "$tool" -q \
    -o Dir::Etc::SourceList="$state/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State="$state" -o Dir::State::Lists="$state/lists" -o Dir::State::Status=/dev/null \
    -o Dir::Cache="$state/cache" -o APT::Sandbox::User="$(id -un)" \
    -o Acquire::Languages=none -o Acquire::Retries=2 \
    -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20 "$@"
}

attempt() {
  apt apt-get update || return 1
  # The Debian revision may change with a rebuild, the upstream archive does not.
  full=$(apt apt-cache showsrc "$package" | sed -n 's/^Version: //p' | grep -F "$version-" | sort -uV | tail -n 1)
  [ -n "$full" ] || { echo "the registry has no source package $package $version" >&2; return 1; }
  (cd "$state/download" && apt apt-get source --download-only --tar-only "$package=$full")
}
attempt >&2 || { echo "first attempt failed, trying once more" >&2; sleep 3; attempt >&2; }

mv "$state/download/${package}_$version".orig.tar.* "$directory/"
