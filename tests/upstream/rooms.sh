#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Rooms of the kernels include headers of rooms below them only. Lists what does not.
#
#   rooms.sh KERNELS

set -eu
cd "$1"
failed=0

# check ROOM LOWER...: what else it includes
check() {
  room=$1; shift
  allowed=$(echo "$room $*" | tr ' ' '|')
  [ -d "$room" ] || { echo "there is no room $room"; failed=1; }
  others=$(grep -rnE '#include "(\.\./)+(api|scene|export|framed|vert|surface|base|embree)/' "$room" | grep -vE "#include \"(\.\./)+($allowed)/" || true)
  [ -z "$others" ] || { echo "$others"; failed=1; }
}

check embree
check base embree
check surface base embree
check vert surface base embree
check framed surface base embree
check export
check scene export vert framed surface base embree
check api scene export vert framed surface base embree
[ "$(find . -name "*.h" | cut -d/ -f2 | sort -u | wc -l)" = 8 ] || { echo "a room is missing here"; failed=1; }
exit $failed
