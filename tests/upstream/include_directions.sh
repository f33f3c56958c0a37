#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that folders of the kernels and of the codec include only headers of lower folders. Lists the includes that
# do not.
#
#   include_directions.sh KERNELS

set -eu
cd "$1"
failed=0

# begin FOLDER: the following checks refer to subfolders of FOLDER
begin() { folder=$1 checked=; }

# check SUBFOLDER LOWER...: SUBFOLDER may include headers of itself and of the subfolders LOWER
check() {
  subfolder=$1
  shift
  checked="$checked|$subfolder"
  [ -d "$folder/$subfolder" ] || {
    echo "no folder $folder/$subfolder"
    failed=1
  }
  for path in "$folder"/*/; do
    other=$(basename "$path")
    case " $subfolder $* " in *" $other "*) continue ;; esac
    found=$(grep -rnE "#include \"(\.\./)+($folder/)?$other/" "$folder/$subfolder" || true)
    [ -z "$found" ] || {
      echo "$found"
      failed=1
    }
  done
}

# Ends the checks of a folder; fails if a subfolder was not checked.
end() {
  for path in "$folder"/*/; do
    case "$checked|" in *"|$(basename "$path")|"*) ;; *)
      echo "no check of $path"
      failed=1
      ;;
    esac
  done
}

begin cvert
check basics
check format basics
check rule format basics
check decoder format basics
check encoder format basics
check file decoder format basics
check clusters basics
end

begin cbvh
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
[ -z "$found" ] || {
  echo "$found"
  failed=1
}

exit $failed
