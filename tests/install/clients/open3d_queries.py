# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes results of rays to FILE.rays and closest points on a torus to FILE.points, computed by Open3D, as bytes. Prints
the numbers of hits, of occluded rays, and of triangles that rays hit.

    open3d_queries.py FILE

Rays of Debian 12's Open3D hit nothing: their mask is 0, and Debian's Embree supports masks. Preload open3d_masks.c.
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
hits = scene.cast_rays(rays)
occluded, counts = scene.test_occlusions(rays).numpy(), scene.count_intersections(rays).numpy()
number = numpy.isfinite(hits["t_hit"].numpy()).sum()
for name, results, others in (("rays", hits, (occluded, counts)), ("points", closest, (distances,))):
    with open(f"{sys.argv[1]}.{name}", "wb") as file:
        for key, values in sorted(results.items()):
            file.write(key.encode() + values.numpy().tobytes())
        for values in others:
            file.write(values.tobytes())
print(number, occluded.sum(), counts.sum())
