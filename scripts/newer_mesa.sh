#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Unpacks lavapipe from Debian's backports, which supports ray queries, into a folder without installing it. Prints
# the value for VK_DRIVER_FILES, for example
#
#   export VK_DRIVER_FILES=$(scripts/newer_mesa.sh build/mesa)
#   build/release/tutorials/pathtracer/cbvh_pathtracer --scene cube --device ray-query
#
# Requires the package registry of a Debian 12, an installed mesa-vulkan-drivers, and 60 MB of disk.
#
#   newer_mesa.sh FOLDER

arguments=1
. "$(dirname -- "$0")/lib.sh"
[ "$#" = 1 ] || usage_error "the argument FOLDER is missing"

mkdir -p "$1"
folder=$(cd "$1" && pwd)
driver=$folder/usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)/libvulkan_lvp.so
icd=$folder/lvp.json
package=mesa-vulkan-drivers

apt=$folder/apt
. scripts/private_apt.sh

download() {
  release=$(. /etc/os-release && echo "$VERSION_CODENAME")
  private_apt_update "$(dpkg --print-architecture)" "$release-backports" "Release: $release" &&
    (cd "$apt" && private_apt apt-get download "$package/$release-backports") || return
  dpkg -x "$apt/$package"_*.deb "$folder" && rm -rf "$apt"
}

if [ ! -e "$driver" ]; then
  download >&2 || {
    echo "newer_mesa.sh: $package cannot be downloaded from the backports" >&2
    exit 1
  }
fi
# The driver depends on the same libraries as Debian 12's, which some machines lack.
if ldd "$driver" | grep -q "not found"; then
  echo "newer_mesa.sh: $(ldd "$driver" | grep 'not found' | tr -s ' \t' ' ')" >&2
  exit 1
fi
printf '{"file_format_version": "1.0.0", "ICD": {"api_version": "1.4.305", "library_path": "%s"}}\n' "$driver" > "$icd"
echo "$icd"
