# shellcheck shell=sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions that read Debian's packages for ARM64 from the mirrors of this machine's apt. The folder $apt contains a
# state of apt in which no package is installed. Source this file; do not run it.

# arm64_apt COMMAND...: runs a command of apt with this state
arm64_apt() {
  "$@" -q -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::Etc::SourceList="$apt/sources.list" \
    -o Dir::Etc::SourceParts=/dev/null -o Dir::State="$apt/state" -o Dir::State::status="$apt/status" \
    -o Dir::Cache="$apt/cache" -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none -o Acquire::Retries=2
}

# Makes the state, and downloads the lists of packages.
arm64_update() {
  mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial" || return
  : > "$apt/status"
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  [ -e "$keys" ] && options="signed-by=$keys" || options=
  apt-get indextargets --format "deb [arch=arm64 $options]"' $(REPO_URI) $(RELEASE) $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' | sort -u > "$apt/sources.list"
  [ -s "$apt/sources.list" ] || { echo "no apt source of Debian's main component" >&2; return 1; }
  arm64_apt apt-get update
}
