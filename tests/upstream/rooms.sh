#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that folders of the kernels and of the codec include only headers of lower folders. Lists the includes that
# do not.
#
#   rooms.sh KERNELS

set -eu
cd "$1"
failed=0

# within HOUSE: selects the folder whose subfolders the following checks refer to
within() { house=$1 rooms= ; }

# check ROOM LOWER...
check() {
  room=$1; shift
  rooms="$rooms|$room"
  [ -d "$house/$room" ] || { echo "no folder $house/$room"; failed=1; }
  for folder in "$house"/*/; do
    other=$(basename "$folder")
    case " $room $* " in *" $other "*) continue ;; esac
    found=$(grep -rnE "#include \"(\.\./)+($house/)?$other/" "$house/$room" || true)
    [ -z "$found" ] || { echo "$found"; failed=1; }
  done
}

# Ends the checks of a house; fails if a folder was not checked.
end() {
  for folder in "$house"/*/; do
    case "$rooms|" in *"|$(basename "$folder")|"*) ;; *) echo "no check of $folder"; failed=1 ;; esac
  done
}

within cvert
check basics
check format basics
check rule format basics
check decoder format basics
check encoder format basics
check file decoder format basics
check clusters basics
end

within cbvh
check embree
check state embree
check base embree
check surface base embree
check vert surface base embree
check framed surface base embree
check stored framed base embree
check files stored framed base embree
check flat stored framed base embree
check building stored vert framed surface base embree
check traversal stored vert framed base embree
check core files stored framed surface base state embree
check api core building traversal files flat stored vert framed surface base state embree
end

# Interfaces outside of libembree3 include the headers of core, which therefore must not include Embree's headers.
found=$(grep -nE '#include "(\.\./)+(cbvh/)?(embree|common)/' cbvh/core/*.h || true)
[ -z "$found" ] || { echo "$found"; failed=1; }

exit $failed
