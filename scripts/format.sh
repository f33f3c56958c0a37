#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Formats all sources: C++, C and GLSL with clang-format 19 (.clang-format), Python with black 23, shell with shfmt.
#
#   format.sh            changes the files
#   format.sh --check    only lists what is not formatted; fails if there is any, with 77 if a formatter is missing
#
# "clang-format off" and "fmt: off" in a source protect tables that are better aligned by hand.

arguments=any
. "$(dirname -- "$0")/lib.sh"
c_mode=-i python_mode=-q shell_mode=-w
[ "${1:-}" != --check ] || c_mode='--dry-run -Werror' python_mode='-q --check' shell_mode=-d

sources() { git ls-files -- "$@"; }
shells() { git grep -lIE '^#!/bin/(ba)?sh' && git ls-files -- '*.sh'; }

for formatter in clang-format-19 black shfmt; do
  command -v "$formatter" > /dev/null || {
    echo "not formatted: $formatter is not installed (package $formatter of Debian 12)" >&2
    exit 77
  }
done

# shellcheck disable=SC2086
{
  status=0
  sources '*.h' '*.cpp' '*.c' '*.glsl' '*.comp' '*.rint' | xargs clang-format-19 $c_mode || status=1
  sources '*.py' | xargs black -l 120 --required-version 23 $python_mode || status=1
  shells | sort -u | xargs shfmt -i 2 -ci -sr $shell_mode || status=1
}
exit "$status"
