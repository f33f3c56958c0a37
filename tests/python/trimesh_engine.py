#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""The ray engine for trimesh returns the hits of a search over all triangles.

Most tests need no trimesh: the engine only reads vertices and faces of the mesh.
"""

import pickle
import types
import unittest

import numpy as np
from trimesh_rays import RayMeshIntersector

try:
    import trimesh
except ImportError:
    trimesh = None


def bumpy_sphere(rows=24, scale=1.0, center=(0, 0, 0)):
    """Vertices, and triangles in shuffled order; the mesh is closed."""
    theta = np.linspace(0, np.pi, rows + 1)[1:-1, None]
    phi = np.linspace(0, 2 * np.pi, 2 * rows, endpoint=False)[None]
    radius = 1 + 0.2 * np.sin(5 * phi) * np.sin(4 * theta)
    rings = radius[..., None] * np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi], axis=-1
    )
    width, last = 2 * rows, (rows - 1) * 2 * rows
    faces = []
    for j in range(width):
        k = (j + 1) % width
        faces += [(last, j, k), (last + 1, last - width + k, last - width + j)]
        for i in range(rows - 2):
            a, b, c, d = i * width + j, i * width + k, (i + 1) * width + j, (i + 1) * width + k
            faces += [(a, c, d), (a, d, b)]
    vertices = np.concatenate([rings.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    faces = np.random.default_rng(5).permutation(np.array(faces))
    return vertices * scale + np.asarray(center), faces


class StandIn(types.SimpleNamespace):
    def __hash__(self):
        return hash(np.asarray(self.vertices).tobytes() + np.asarray(self.faces).tobytes())


def sphere(**options):
    vertices, faces = bumpy_sphere(**options)
    return StandIn(vertices=vertices, faces=faces)


def rays_at(mesh, count, seed):
    rng = np.random.default_rng(seed)
    vertices = np.asarray(mesh.vertices)
    center, size = vertices.mean(axis=0), np.ptp(vertices, axis=0).max()
    origins = center + rng.normal(size=(count, 3)) * size
    return origins, center + rng.normal(size=(count, 3)) * size / 4 - origins


def every_hit(mesh, origins, directions):
    """Distances (n, triangles) by Moeller and Trumbore in double precision; inf where there is no hit."""
    a, b, c = np.moveaxis(np.asarray(mesh.vertices)[mesh.faces], 1, 0)
    distances = np.full((len(origins), len(a)), np.inf)
    for i, (origin, direction) in enumerate(zip(origins, directions)):
        across = np.cross(direction, c - a)
        determinant = ((b - a) * across).sum(axis=1)
        u = ((origin - a) * across).sum(axis=1) / determinant
        q = np.cross(origin - a, b - a)
        v = q @ direction / determinant
        t = ((c - a) * q).sum(axis=1) / determinant
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        distances[i, hit] = t[hit]
    return distances


class Queries(unittest.TestCase):
    def test_other_vertices_do_not_matter(self):
        for rows in (6, 24):  # few triangles and many
            mesh = sphere(rows=rows)
            rays = rays_at(mesh, 200, seed=3)
            expected = RayMeshIntersector(mesh).intersects_first(*rays)
            self.assertGreater((expected != -1).sum(), 50)
            for other in (np.nan, np.inf, -1e12):
                mesh.vertices = np.concatenate([sphere(rows=rows).vertices, [[other] * 3]])
                np.testing.assert_array_equal(RayMeshIntersector(mesh).intersects_first(*rays), expected)

    def check(self, mesh, count=300):
        origins, directions = rays_at(mesh, count, seed=count)
        distances = every_hit(mesh, origins, directions)
        engine = RayMeshIntersector(mesh)
        hit = np.isfinite(distances).any(axis=1)
        self.assertGreater(hit.sum(), count // 3)

        first = engine.intersects_first(origins, directions)
        expected = np.where(hit, distances.argmin(axis=1), -1)
        # Rays that pass an edge within rounding may hit the other triangle, or pass the silhouette.
        self.assertLessEqual((first != expected).sum(), count // 100)
        np.testing.assert_array_equal(engine.intersects_any(origins, directions), first != -1)

        locations, rays, triangles = engine.intersects_location(origins, directions)
        found = np.bincount(rays, minlength=count)
        self.assertLessEqual((found != np.isfinite(distances).sum(axis=1)).sum(), count // 100)
        self.assertGreater(found.max(), 2)
        size = np.ptp(mesh.vertices, axis=0).max()
        corners = np.asarray(mesh.vertices)[mesh.faces[triangles]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        self.assertLess(np.abs(((locations - corners[:, 0]) * normals).sum(axis=1)).max(), 1e-9 * size)
        self.assertLess(np.linalg.norm(locations - corners.mean(axis=1), axis=1).max(), size / 4)

        closest, of_ray = engine.intersects_id(origins, directions, multiple_hits=False)
        np.testing.assert_array_equal(closest, first[first != -1])
        np.testing.assert_array_equal(of_ray, np.nonzero(first != -1)[0])
        twice, _ = engine.intersects_id(origins, directions, max_hits=2)
        self.assertEqual(len(twice), np.minimum(found, 2).sum())

    def test_hits_match_a_search_over_all_triangles(self):
        self.check(sphere())

    def test_small_meshes_work_too(self):
        mesh = sphere(rows=10)
        mesh.faces = mesh.faces[:255]
        self.check(mesh)
        nothing = StandIn(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), int))
        first = RayMeshIntersector(nothing).intersects_first([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
        self.assertEqual(first.tolist(), [-1])

    def test_scale_and_position_do_not_matter(self):
        for scale, center in ((1e-6, (0, 0, 0)), (1e7, (0, 0, 0)), (1, (1e5, -2e5, 3e5))):
            with self.subTest(scale=scale, center=center):
                self.check(sphere(scale=scale, center=center), 100)

    def test_changed_mesh_is_built_again(self):
        mesh = sphere()
        engine = RayMeshIntersector(mesh)
        above, down = [[0.05, 0.02, 5.0]], [[0.0, 0.0, -2.0]]
        self.assertTrue(engine.intersects_any(above, down)[0])
        mesh.vertices = mesh.vertices + [3, 0, 0]
        self.assertFalse(engine.intersects_any(above, down)[0])

    def test_rays_that_miss(self):
        engine = RayMeshIntersector(sphere())
        away = [[0.0, 0.0, 5.0]] * 17, [[0.0, 0.0, 1.0]] * 17
        self.assertEqual(engine.intersects_first(*away).tolist(), [-1] * 17)
        locations, rays, triangles = engine.intersects_location(*away)
        self.assertEqual((locations.shape, rays.shape, triangles.shape), ((0, 3), (0,), (0,)))
        self.assertEqual(engine.intersects_first(np.zeros((0, 3)), np.zeros((0, 3))).shape, (0,))
        with self.assertRaises(ValueError):
            engine.intersects_first(np.zeros((2, 3)), np.zeros((3, 3)))

    def test_mesh_is_compressed(self):
        mesh = sphere(rows=100)
        self.assertLess(RayMeshIntersector(mesh).memory_bytes(), 12 * len(mesh.faces))

    def test_engine_is_pickled_without_its_scene(self):
        mesh = sphere()
        engine = pickle.loads(pickle.dumps(RayMeshIntersector(mesh)))
        self.assertTrue(engine.intersects_any([[0.05, 0.02, 5.0]], [[0.0, 0.0, -1.0]])[0])

    @unittest.skipUnless(trimesh, "no trimesh")
    def test_trimesh_uses_the_engine(self):
        mesh = trimesh.Trimesh(*bumpy_sphere())
        mesh.ray = RayMeshIntersector(mesh)
        rng = np.random.default_rng(7)
        points = rng.uniform(-1.3, 1.3, size=(2000, 3))
        # The mesh is less than 0.02 from the surface that its vertices sample.
        theta = np.arccos(points[:, 2] / np.linalg.norm(points, axis=1))
        radius = 1 + 0.2 * np.sin(5 * np.arctan2(points[:, 1], points[:, 0])) * np.sin(4 * theta)
        distances = np.linalg.norm(points, axis=1) - radius
        clear = np.abs(distances) > 0.05
        contained = mesh.contains(points)
        self.assertGreater(contained.sum(), 200)
        np.testing.assert_array_equal(contained[clear], distances[clear] < 0)


if __name__ == "__main__":
    unittest.main()
