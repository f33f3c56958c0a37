#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Installs our Debian packages in separate root file systems. Requires root, debootstrap, the machine's package
# registry and 4 GB:
#
#   - on a minimal Debian, apt installs them and our programs run;
#   - on another one, scripts/demo.sh renders with their program instead of building it, if the packages were built from
#     the committed state;
#   - on a Debian 12 with Debian's Embree, and Blender, Open3D and Embree's tutorials, they replace Debian's packages,
#     the other programs stay installed, and their results are identical.
#
#   packages.sh DIRECTORY-OF-PACKAGES DIRECTORY-FOR-ROOTS [bookworm|trixie]
#
# The last argument is the release on which the packages were built, by default bookworm, Debian 12.
set -eu
packages=$(cd "$1" && pwd) roots=$2 suite=${3:-bookworm}
here=$(cd -- "$(dirname -- "$0")" && pwd)
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
fail() {
  echo "FAILED: $*" >&2
  exit 1
}

mkdir -p "$roots"
roots=$(cd "$roots" && pwd)
release() {
  for root in bare demo clients; do umount "$roots/$root/proc" "$roots/$root/dev" 2> /dev/null || true; done
}
trap release EXIT

# make ROOT: creates a root file system with debootstrap, from the mirror of this machine
make() {
  root=$roots/$1
  base=$roots/base-$suite
  if [ ! -d "$base" ]; then
    mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 'Origin: Debian' 'Component: main' |
      sort -u | head -n 1)
    debootstrap --variant=minbase "$suite" "$base.part" "$mirror" > "$roots/log" ||
      {
        tail "$roots/log"
        fail "debootstrap cannot make $base.part"
      }
    mv "$base.part" "$base"
  fi
  rm -rf --one-file-system "$root"
  cp -a "$base" "$root"
  cp /etc/resolv.conf "$root/etc/"
  mkdir -p "$root/root/packages" "$root/root/clients"
  cp "$packages"/*.deb "$root/root/packages/"
  cp "$here"/clients/* "$root/root/clients/"
  mount --bind /proc "$root/proc"
  mount --bind /dev "$root/dev"
  apt_get update
}
inside() { chroot "$root" env HOME=/root "$@"; }
apt_get() { inside apt-get -q -y --no-install-recommends "$@" > "$roots/log" 2>&1 ||
  {
    tail -n 30 "$roots/log"
    fail "apt-get $* does not succeed"
  }; }
ours() {
  apt_get install "$@"
  apt_get check
}
all() { (cd "$packages" && for package in *.deb; do echo "/root/packages/$package"; done); }
status() { inside dpkg-query -W -f '${db:Status-Status}' "$1" 2> /dev/null || true; }

# --- a minimal system ------------------------------------------------------------------------------

make bare
# shellcheck disable=SC2046
ours $(all)
inside cbvh_render --version
inside cbvh_render --scene cube --level 3 --size 32x32 --representation cvert --output /root/pictures \
  > "$roots/log" 2>&1 ||
  {
    cat "$roots/log"
    fail "cbvh_render does not run"
  }
inside python3 -c "import embree_cbvh as cbvh
scene = cbvh.build(cbvh.Model.generate('cube'), 'cvert', 3)
print('Python module', cbvh.__version__, scene.statistics()['bytes_per_quad'])" ||
  fail "the Python module does not build a scene"
# CPack counts a library once more for each of its links.
for package in libembree3-cbvh libembree-cbvh1; do
  stated=$(inside dpkg-query -W -f '${Installed-Size}' "$package")
  # shellcheck disable=SC2016
  actual=$(inside sh -c 'dpkg -L "$1" | while read -r file; do [ ! -f "$file" ] || [ -L "$file" ] || stat -c %s "$file"
    done' sh "$package" | awk '{ sum += $1 } END { print int(sum/1024) }')
  [ "$stated" -lt $((actual + actual / 10)) ] || fail "$package states $stated KiB but has $actual"
done
apt_get remove libembree3-cbvh
[ ! -e "$root/usr/lib/x86_64-linux-gnu/libembree3.so.3" ] || fail "the library still exists after the removal"
echo "a minimal system installs and removes the packages"

# --- scripts/demo.sh with packages in output/ -------------------------------------------------------

make demo
git -C "$here/../.." archive --prefix=root/embree-cbvh/ HEAD | tar -x -C "$root"
mkdir "$root/root/embree-cbvh/output"
cp "$packages"/*.deb "$root/root/embree-cbvh/output/"
inside /root/embree-cbvh/scripts/demo.sh --short > "$roots/log" 2>&1 ||
  {
    tail -n 30 "$roots/log"
    fail "scripts/demo.sh does not run"
  }
grep '^output/embree-cbvh-tools_.* these sources' "$roots/log" ||
  {
    grep '^output/' "$roots/log"
    fail "the demo does not use the packages"
  }

# --- a system with Debian's packages ---------------------------------------------------------------

[ "$suite" = bookworm ] || {
  echo "$suite has no Embree 3 that our packages replace"
  exit 0
}

# run FOLDER: stores the results of each client
run() {
  inside mkdir -p "/root/$1"
  for program in triangle_geometry subdivision_geometry displacement_geometry instanced_geometry curve_geometry \
    grid_geometry point_geometry interpolation user_geometry intersection_filter hair_geometry \
    lazy_geometry motion_blur_geometry; do
    inside "$program" --size 160 120 -o "/root/$1/$program.ppm" > "$roots/log" 2>&1 ||
      {
        cat "$roots/log"
        fail "$program does not render its picture"
      }
  done
  for program in viewer pathtracer; do
    inside "$program" -c /usr/share/doc/embree3/models/cornell_box.ecs --size 80 60 -o "/root/$1/$program.ppm" \
      > "$roots/log" 2>&1 ||
      {
        cat "$roots/log"
        fail "$program does not render its picture"
      }
  done
  inside python3 /root/clients/open3d_queries.py "/root/$1/open3d" || fail "Open3D does not run its queries"
  hits=$(inside env LD_PRELOAD=/root/clients/open3d_masks.so python3 /root/clients/open3d_queries.py \
    "/root/$1/open3d_masks") || fail "Open3D does not run its queries with masks"
  [ "${hits%% *}" -gt 0 ] || fail "Open3D's rays with masks hit nothing"
  inside blender -b --python-exit-code 1 --python /root/clients/blender.py -- "/root/$1/blender.bmp" \
    > "$roots/log" 2>&1 ||
    {
      cat "$roots/log"
      fail "Blender does not render its picture"
    }
}

# compare FOLDER OTHER
compare() {
  for file in "$root/root/$1"/*; do
    cmp "$file" "$root/root/$2/${file##*/}" || fail "${file##*/} differs"
  done
  echo "$(find "$root/root/$1" -type f | wc -l) files are identical: $3"
}

make clients
apt_get install embree-tools libembree-dev blender python3-open3d
cc -shared -fPIC -idirafter "$root/usr/include" "$here/clients/open3d_masks.c" -ldl \
  -o "$root/root/clients/open3d_masks.so"
run stock
ours "$(all | grep /libembree3-cbvh_)" "$(all | grep /libembree-cbvh-dev_)"
for package in libembree3-3 libembree-dev; do
  [ "$(status $package)" != installed ] || fail "$package is still installed"
done
run library
compare stock library "Debian's programs on our library"
# shellcheck disable=SC2046
ours $(all)
for package in embree-tools libembree3-3; do
  [ "$(status $package)" != installed ] || fail "$package is still installed"
done
for package in blender python3-open3d; do
  [ "$(status $package)" = installed ] || fail "$package was removed"
done
run tools
compare stock tools "with our programs instead of embree-tools"
