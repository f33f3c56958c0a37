#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Unpacks lavapipe from Debian's backports, which supports ray queries, into a folder without installing it. Prints
# the value for VK_DRIVER_FILES, for example
#
#   export VK_DRIVER_FILES=$(scripts/newer_mesa.sh build/mesa)
#   build/release/tutorials/pathtracer/cbvh_pathtracer --scene cube --device vulkan --ray-query
#
# Requires the package registry of a Debian 12, an installed mesa-vulkan-drivers, and 60 MB of disk.
#
#   newer_mesa.sh FOLDER

arguments=1
. "$(dirname -- "$0")/lib.sh"
[ "$#" = 1 ] || refuse "the argument FOLDER is missing"

mkdir -p "$1"
folder=$(cd "$1" && pwd)
driver=$folder/usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)/libvulkan_lvp.so
icd=$folder/lvp.json
package=mesa-vulkan-drivers

# Runs apt with its own lists: the machine's registry and its backports.
run() {
  "$@" -o Dir::Etc::SourceList="$folder/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State="$folder/apt/state" -o Dir::State::status=/var/lib/dpkg/status -o Dir::Cache="$folder/apt/cache" \
    -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none -o Acquire::Retries=2 \
    -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20
}

download() {
  mkdir -p "$folder/apt/state/lists/partial" "$folder/apt/cache/archives/partial"
  release=$(. /etc/os-release && echo "$VERSION_CODENAME")
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  [ -e "$keys" ] && options="[signed-by=$keys] " || options=
  apt-get indextargets --format "deb $options"'$(REPO_URI) '"$release-backports"' $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' "Release: $release" | sort -u > "$folder/apt/sources.list"
  [ -s "$folder/apt/sources.list" ] || { echo "no apt source of Debian's main component" >&2; return 1; }
  run apt-get -q update && (cd "$folder/apt" && run apt-get -q download "$package/$release-backports") || return
  dpkg -x "$folder"/apt/"$package"_*.deb "$folder" && rm -rf "$folder/apt"
}

if [ ! -e "$driver" ]; then
  download >&2 || { echo "newer_mesa.sh: $package cannot be downloaded from the backports" >&2; exit 1; }
fi
# The driver depends on the same libraries as Debian 12's, which some machines lack.
if ldd "$driver" | grep -q "not found"; then
  echo "newer_mesa.sh: $(ldd "$driver" | grep 'not found' | tr -s ' \t' ' ')" >&2
  exit 1
fi
printf '{"file_format_version": "1.0.0", "ICD": {"api_version": "1.4.305", "library_path": "%s"}}\n' "$driver" > "$icd"
echo "$icd"
