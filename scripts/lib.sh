# shellcheck shell=sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions that the commands of this directory share. Source this file; do not run it.

set -eu

# Prints the help of a script: the comment at its top.
print_help() { sed -n '5,/^$/s/^# \{0,1\}//p' "$0"; }

# usage_error MESSAGE: prints the message, refers to --help, and exits with 2.
usage_error() {
  echo "$(basename -- "$0"): $1, see --help" >&2
  exit 2
}

# Prints the help on request. Rejects options, and more arguments than `arguments` allows. A script sets `arguments`
# before it sources this file. With `any`, all arguments pass, and the script's command checks them.
for argument in "$@"; do
  case $argument in
    -h | --help)
      print_help
      exit 0
      ;;
    -*) [ "${arguments:-0}" = any ] || usage_error "unknown option $argument" ;;
  esac
done
[ "${arguments:-0}" = any ] || [ "$#" -le "${arguments:-0}" ] ||
  usage_error "too many arguments ($*): expected at most ${arguments:-0}"

root=$(cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
jobs=$(nproc)
summary=

# phase NAME COMMAND...: runs the command and notes its duration. `set -e` has no effect inside functions that run
# here.
phase() {
  name=$1
  shift
  echo "== $name"
  start=$(date +%s)
  failed=0
  "$@" || failed=$?
  took=$(($(date +%s) - start))
  total=$((${total:-0} + took))
  summary="$summary$(printf '  %-28s %5d s' "$name" "$took")
"
  [ "$failed" = 0 ] || {
    echo "$name failed" >&2
    exit "$failed"
  }
}

# Prints the durations of all phases, also after a failure.
print_summary() {
  [ -z "$summary" ] || printf '== time\n%s  %-28s %5d s\n' "$summary" total "${total:-0}"
}
trap print_summary EXIT

# Installs the missing packages of scripts/packages. Skips a package if an installed one provides it: our packages
# provide Debian's Embree, and installing Debian's would remove them.
# Prints and skips packages that the distribution lacks: a test that needs one is then skipped.
#   install_packages [LINE]    the packages above this line of the file; by default those for the build and the tests
install_packages() {
  command -v dpkg-query > /dev/null ||
    {
      echo "this machine has no dpkg: docs/platforms.md lists the packages"
      return 0
    }
  missing=
  present=" $(dpkg-query -W -f '${db:Status-Status} ${Package}, ${Provides}\n' | sed -n 's/^installed //p' |
    tr ',' '\n' | sed 's/^ *//; s/[ :].*//' | tr '\n' ' ') "
  for package in $(sed -n "/${1:-Only a wheel requires}/q;s/#.*//;p" scripts/packages); do
    case $present in
      *" $package "*) ;;
      *) missing="$missing $package" ;;
    esac
  done
  [ -n "$missing" ] || {
    echo "every package is present"
    return 0
  }
  apt_as_root update || return
  # shellcheck disable=SC2086
  available=$(LC_ALL=C apt-cache policy $missing |
    awk '/^[^ ]/ { n = $1 } $1 == "Candidate:" && $2 != "(none)" { print n }')
  chosen=
  for package in $missing; do
    case "
$available" in
      *"
$package:"*) chosen="$chosen $package" ;;
      *) echo "not available here: $package" ;;
    esac
  done
  [ -n "$chosen" ] || return 0
  echo "installing$chosen"
  # shellcheck disable=SC2086
  apt_as_root --no-install-recommends install $chosen
}

# apt_as_root COMMAND ARGUMENT...: apt-get without questions
apt_as_root() {
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=600 -o Dpkg::Use-Pty=0 "$@"
}

# run_apt COMMAND ARGUMENT...: the same after an update of its lists
run_apt() { apt_as_root update && apt_as_root --no-install-recommends "$@"; }

# configure [PRESET]
configure() {
  cmake --preset "${1:-release}" ${EMBREE_UPSTREAM_ARCHIVE:+"-DEMBREE_UPSTREAM_ARCHIVE=$EMBREE_UPSTREAM_ARCHIVE"}
}

# build [PRESET [TARGET...]]: prints the progress and the smallest estimate of the remaining time so far every ten
# seconds. Estimates vary in both directions, because files at the beginning and at the end take longer than others.
build() {
  preset=${1:-release}
  [ "$#" = 0 ] || shift
  {
    failed=0
    NINJA_STATUS='@%f %t %e@' cmake --build --preset "$preset" -j "$jobs" ${1:+--target "$@"} 2>&1 || failed=$?
    echo "@exit $failed@"
  } | {
    shown=-10
    least=
    while IFS= read -r line; do
      case $line in
        @exit*)
          status=${line#@exit }
          exit "${status%@}"
          ;;
        @[0-9]*)
          status=${line#@} # number of finished files, number of all files, seconds
          status=${status%%@*}
          built=${status%% *} of=${status#* } seconds=${status##* }
          of=${of% *} seconds=${seconds%.*}
          [ "$built" -gt 0 ] && [ "$seconds" -ge $((shown + 10)) ] || continue
          shown=$seconds
          left=$((seconds * (of - built) / built))
          [ -n "$least" ] && [ "$left" -ge "$least" ] || least=$left
          minutes=$((least / 60))
          case $minutes in
            0) left= ;;
            1) left=", at least a minute left" ;;
            *) left=", at least $minutes minutes left" ;;
          esac
          echo "  $built of $of files$left"
          ;;
        *) printf '%s\n' "$line" ;;
      esac
    done
    exit 1
  }
}
