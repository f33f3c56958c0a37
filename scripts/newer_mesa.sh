#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# A newer lavapipe than Debian 12's, with ray queries, from Debian's backports: unpacked into a folder, not installed. Prints what
# VK_DRIVER_FILES is to be, as in
#
#   VK_DRIVER_FILES=$(scripts/newer_mesa.sh build/mesa) build/release/tutorials/pathtracer/cbvh_pathtracer --scene cube --device vulkan --ray-query
#
# It needs the package registry of a Debian 12 with mesa-vulkan-drivers, and 60 MB.
#
#   newer_mesa.sh FOLDER

arguments=1
. "$(dirname -- "$0")/lib.sh"
[ "$#" = 1 ] || refuse "there is no folder"

mkdir -p "$1"
folder=$(cd "$1" && pwd)
driver=$folder/usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)/libvulkan_lvp.so
icd=$folder/lvp.json
package=mesa-vulkan-drivers

# apt with lists of its own: those of the machine's registry, and its backports
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
  download >&2 || { echo "newer_mesa.sh: $package of the backports cannot be had" >&2; exit 1; }
fi
# libraries that the driver needs are those that Debian 12's needs, but for a machine that has none of them
if ldd "$driver" | grep -q "not found"; then
  echo "newer_mesa.sh: $(ldd "$driver" | grep 'not found' | tr -s ' \t' ' ')" >&2
  exit 1
fi
printf '{"file_format_version": "1.0.0", "ICD": {"api_version": "1.4.305", "library_path": "%s"}}\n' "$driver" > "$icd"
echo "$icd"
