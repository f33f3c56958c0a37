#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Open3D casts rays with Embree. Debian builds Open3D against its own libembree3, which supports ray masks.
#
# Guess: rays straight at a sphere hit it.
#
# Seen (Open3D 0.16.1 and Embree 3.13.5 of Debian 12): all rays miss. Open3D leaves the masks of its rays 0, which means
# "no geometry" to an Embree with ray masks. The rays also miss with our libembree3 (docs/renderers.md).
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm python3-open3d=0.16.1+ds-2+b4 libembree3-3=3.13.5+dfsg-2

cat > "$root/rays.py" << 'PYTHON'
import numpy as np
import open3d as o3d

scene = o3d.t.geometry.RaycastingScene()
scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(o3d.geometry.TriangleMesh.create_sphere()))
offsets = np.linspace(-0.5, 0.5, 10)
rays = np.array([(x, y, 5, 0, 0, -1) for x in offsets for y in offsets], np.float32)
hits = scene.cast_rays(o3d.core.Tensor(rays))["t_hit"].numpy()
print(np.isfinite(hits).sum(), "of", len(rays))
PYTHON
export PYTHONHOME="$root/system/usr" PYTHONPATH="$root/system/usr/lib/python3/dist-packages"
observe "rays that hit" "0 of 100" "$(in_root python3.11 "$root/rays.py")"
