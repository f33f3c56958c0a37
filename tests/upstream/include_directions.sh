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
check portable
check format portable
check rule format portable
check decoder format portable
check encoder format portable
check conversion encoder decoder format portable
check file decoder format portable
check clusters portable
end

begin cbvh
check embree
check settings embree
check base settings embree
check surface base settings embree
check exact surface base settings embree
check paper surface base settings embree
check blocks paper base settings embree
check files blocks paper base settings embree
check backend blocks paper base settings embree
check building blocks exact paper surface base settings embree
check traversal blocks exact paper base settings embree
check operations files blocks paper surface base settings embree
check api operations building traversal files backend blocks exact paper surface base settings embree
end

# Interfaces outside of libembree3 include the headers of operations, which therefore must not include Embree's headers.
found=$(grep -nE '#include "(\.\./)+(cbvh/)?(embree|common)/' cbvh/operations/*.h || true)
[ -z "$found" ] || {
  echo "$found"
  failed=1
}

exit $failed
