# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes closest points on a torus and hits of rays, computed by Open3D, as bytes.   FILE

The rays hit nothing on Debian: their mask is 0, and Debian's Embree supports masks.
"""

import sys

import numpy
import open3d

scene = open3d.t.geometry.RaycastingScene()
torus = open3d.geometry.TriangleMesh.create_torus(1.0, 0.4, 200, 100)
scene.add_triangles(open3d.t.geometry.TriangleMesh.from_legacy(torus))
rays = scene.create_rays_pinhole(fov_deg=60, center=[0, 0, 0], eye=[2, 2, 2], up=[0, 0, 1], width_px=320, height_px=240)
points = open3d.core.Tensor(numpy.random.default_rng(1).uniform(-1.5, 1.5, (20000, 3)).astype(numpy.float32))
closest = scene.compute_closest_points(points)
distances = scene.compute_distance(points).numpy()
assert 0 < distances.min() < 0.01 < distances.max()
with open(sys.argv[1], "wb") as file:
    for name, values in sorted(closest.items()) + sorted(scene.cast_rays(rays).items()):
        file.write(name.encode() + values.numpy().tobytes())
    file.write(distances.tobytes())
