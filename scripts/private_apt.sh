# shellcheck shell=sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions that read packages from the mirrors of this machine's apt. The folder $apt contains a state of apt in which
# no package is installed; this machine's lists of packages do not change. Source this file; do not run it.

# private_apt COMMAND...: runs a command of apt with this state
private_apt() {
  "$@" -q -o APT::Architecture="$architecture" -o APT::Architectures="$architecture" \
    -o Dir::Etc::SourceList="$apt/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State="$apt/state" -o Dir::State::status="$apt/status" -o Dir::Cache="$apt/cache" \
    -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none -o Acquire::Retries=2 \
    -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20
}

# private_apt_update ARCHITECTURE SUITE FILTER: makes the state, and downloads the lists of Debian's main component.
#   SUITE     a release, or '$(RELEASE)' for the releases that this machine uses
#   FILTER    selects indices of this machine whose mirrors are used, see apt-get indextargets
private_apt_update() {
  architecture=$1
  mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial" || return
  : > "$apt/status"
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  [ -e "$keys" ] && keys=" signed-by=$keys" || keys=
  apt-get indextargets --format "deb [arch=$architecture$keys]"' $(REPO_URI) '"$2"' $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' "$3" | sort -u > "$apt/sources.list"
  [ -s "$apt/sources.list" ] ||
    {
      echo "apt has no index of Debian's main component: run apt-get update" >&2
      return 1
    }
  private_apt apt-get update
}
