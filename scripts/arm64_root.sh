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
[ "$#" = 1 ] || refuse "the argument FOLDER is missing"

packages="libc6-dev libstdc++-12-dev libtbb-dev libcli11-dev libopenexr-dev libopenimageio-dev libosd-dev
  nlohmann-json3-dev libgl-dev libglfw3-dev pybind11-dev python3-dev python3-numpy libvulkan-dev libvulkan-volk-dev
  mesa-vulkan-drivers vulkan-validationlayers embree-tools libembree-dev libgtest-dev"

mkdir -p "$1"
folder=$(cd "$1" && pwd)
apt=$folder/apt

# apt with a state of its own, in which no package is installed
run() {
  "$@" -q -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::Etc::SourceList="$apt/sources.list" \
    -o Dir::Etc::SourceParts=/dev/null -o Dir::State="$apt/state" -o Dir::State::status="$apt/status" \
    -o Dir::Cache="$apt/cache" -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none -o Acquire::Retries=2
}

download() {
  mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial"
  : > "$apt/status"
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  [ -e "$keys" ] && options="signed-by=$keys" || options=
  apt-get indextargets --format "deb [arch=arm64 $options]"' $(REPO_URI) $(RELEASE) $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' | sort -u > "$apt/sources.list"
  [ -s "$apt/sources.list" ] || { echo "no apt source of Debian's main component" >&2; return 1; }
  # shellcheck disable=SC2086
  run apt-get update && run apt-get install -y --download-only --no-install-recommends $packages
}
download >&2 || { echo "arm64_root.sh: the packages could not be downloaded" >&2; exit 1; }

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
