#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Unpacks cbvh_render from a wheel or from Debian packages of this project in output/, so that it can be used without a
# build. build/prebuilt/cbvh_render then starts it. Fails if there is none that fits, and says why each was
# rejected.
#
#   scripts/prebuilt.sh
#
# A file fits if it was built from exactly the sources of this folder, and if cbvh_render starts on this system. Debian
# packages, which are libembree3-cbvh_*.deb and embree-cbvh-tools_*.deb of scripts/package.sh, may need libraries: apt
# installs these, but not the packages themselves.

. "$(dirname -- "$0")/lib.sh"

sources=$(scripts/packaging/sources.sh)
folder=build/prebuilt

reject() {
  echo "$1 is not used: $2"
  return 1
}

# same_sources FILE HASH-FILE
same_sources() {
  [ "$(cat "$2" 2> /dev/null)" = "$sources" ] || reject "$1" "it was built from other sources"
}

starts() { "$folder/cbvh_render" --version > "$folder/log" 2>&1; }

reason() { echo "cbvh_render does not start: $(tail -n 1 "$folder/log")"; }

try_wheel() {
  if command -v python3 > /dev/null; then
    python3 -m zipfile -e "$1" "$folder"
  else
    command -v unzip > /dev/null || run_apt install unzip && unzip -q "$1" -d "$folder"
  fi || reject "$1" "it cannot be unpacked" || return
  same_sources "$1" "$folder"/embree_cbvh-*.dist-info/sources.sha256 || return
  chmod +x "$folder"/embree_cbvh/bin/*
  ln -s embree_cbvh/bin/cbvh_render "$folder/cbvh_render"
  starts || reject "$1" "$(reason)"
}

# try_packages PACKAGE-OF-PROGRAMS
try_packages() {
  library=output/libembree3-cbvh${1#output/embree-cbvh-tools}
  for package in "$library" "$1"; do
    dpkg-deb -x "$package" "$folder" || reject "$1" "$package cannot be unpacked" || return
    name=${package#output/}
    same_sources "$1" "$folder/usr/share/doc/${name%%_*}/sources.sha256" || return
  done
  libraries=$(cd "$folder"/usr/lib/*/ && pwd)
  printf '#!/bin/sh\nLD_LIBRARY_PATH="%s" exec "%s" "$@"\n' "$libraries" "$root/$folder/usr/bin/cbvh_render" \
    > "$folder/cbvh_render"
  chmod +x "$folder/cbvh_render"
  starts && return
  # without libembree3-cbvh, which is unpacked, and libembree3-3, which it provides
  needed=$(dpkg-deb -f "$1" Depends | sed 's/libembree3-[^,]*,\{0,1\}//g')
  needed="$(dpkg-deb -f "$library" Depends), $needed"
  echo "installing what $1 needs"
  run_apt --no-remove satisfy "$needed" && starts || reject "$1" "$(reason)"
}

found=no
for file in output/embree_cbvh-*_"$(uname -m)".whl \
  output/embree-cbvh-tools_*_"$(dpkg --print-architecture 2> /dev/null)".deb; do
  [ -e "$file" ] || continue
  found=yes
  rm -rf "$folder"
  mkdir -p "$folder"
  case $file in
    *.whl) try_wheel "$file" || continue ;;
    *.deb) try_packages "$file" || continue ;;
  esac
  echo "$file was built from these sources, and is used"
  exit
done
rm -rf "$folder"
[ $found = yes ] || echo "output/ has no wheel and no Debian packages for this machine"
exit 1
