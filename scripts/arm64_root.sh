#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Fills a folder with Debian's libraries and headers for ARM64: what the presets `arm64` and `package-arm64` link, and
# what their programs load under qemu-aarch64-static. The folder DEBIAN in it lists the packages of the libraries, for
# dpkg-shlibdeps. Packages are unpacked, not installed, and none of their programs runs. Requires the package registry
# of a Debian and 1.2 GB of disk, but not root.
#
#   arm64_root.sh FOLDER

arguments=1
. "$(dirname -- "$0")/lib.sh"
[ "$#" = 1 ] || usage_error "the argument FOLDER is missing"

packages="libc6-dev libstdc++-12-dev libtbb-dev libcli11-dev libopenexr-dev libopenimageio-dev libosd-dev libtiff-dev
  nlohmann-json3-dev libgl-dev libglfw3-dev pybind11-dev python3-dev python3-numpy libvulkan-dev libvulkan-volk-dev
  mesa-vulkan-drivers vulkan-validationlayers embree-tools libembree-dev libgtest-dev"

mkdir -p "$1"
folder=$(cd "$1" && pwd)
apt=$folder/apt

. scripts/private_apt.sh

download() {
  # shellcheck disable=SC2086
  private_apt_update arm64 '$(RELEASE)' 'Component: main' &&
    private_apt apt-get install -y --download-only --no-install-recommends $packages
}
download >&2 || {
  echo "arm64_root.sh: the packages could not be downloaded" >&2
  exit 1
}

# As Debian merges them: /lib is /usr/lib.
for name in bin lib sbin; do
  mkdir -p "$folder/usr/$name"
  [ -e "$folder/$name" ] || ln -s "usr/$name" "$folder/$name"
done
rm -rf "$folder/DEBIAN"
mkdir "$folder/DEBIAN"
for package in "$apt"/cache/archives/*.deb; do
  dpkg-deb --fsys-tarfile "$package" | tar -x --keep-directory-symlink -f - -C "$folder"
  for file in shlibs symbols; do
    dpkg-deb --info "$package" "$file" >> "$folder/DEBIAN/$file" 2> /dev/null || true # few packages have them
  done
done
rm -rf "$apt"

# In place of the packages' install scripts: the alternative that NumPy needs, and links that stay inside the folder.
libraries=$folder/usr/lib/aarch64-linux-gnu
ln -sf blas/libblas.so.3 lapack/liblapack.so.3 "$libraries"
find "$folder/usr/lib" -type l -lname '/*' | while IFS= read -r link; do
  ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$folder$(readlink "$link")")" "$link"
done
