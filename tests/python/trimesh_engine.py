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
from triangle_distances import distances_to_triangles
from trimesh_rays import ProximityQuery, RayMeshIntersector

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


def plates(count, cells):
    """Closed boxes above each other, of height 0.5 at z = 0, 1, 2..., with cells x cells quads on each large side."""
    sides = np.arange(cells + 1) * 1.0
    y, x = np.meshgrid(sides, sides, indexing="ij")
    layer = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    width = cells + 1
    corner = (np.arange(cells)[:, None] * width + np.arange(cells)).reshape(-1)
    quads = np.stack([corner, corner + 1, corner + width + 1, corner + width], axis=-1)
    around = [
        *range(width),
        *range(2 * width - 1, width * width, width),
        *range(width * width - 2, width * cells, -1),
        *range(width * cells, 0, -width),
    ]
    walls = [[a, b, b + width * width, a + width * width] for a, b in zip(around, around[1:] + around[:1])]
    quads = np.concatenate([quads[:, ::-1], quads + width * width, walls])
    faces = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    vertices = np.concatenate([layer + [0, 0, z + top] for z in range(count) for top in (0, 0.5)])
    faces = np.concatenate([faces + 2 * width * width * z for z in range(count)])
    return StandIn(vertices=vertices, faces=faces)


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

    def test_all_hits_are_returned_unless_a_bound_is_given(self):
        for cells in (1, 3):  # few triangles and many: 12 and 60 per box
            mesh = plates(15 if cells == 1 else 60, cells)
            hits = 30 if cells == 1 else 120
            engine = RayMeshIntersector(mesh)
            rng = np.random.default_rng(2)
            origins = np.append(rng.uniform(0.1, 0.9, (50, 2)) * cells, np.full((50, 1), -1), axis=1)
            rays = origins, np.tile([0.0, 0.0, 1.0], (50, 1))
            locations, of_rays, triangles = engine.intersects_location(*rays)
            self.assertEqual(np.bincount(of_rays).tolist(), [hits] * 50)
            np.testing.assert_allclose(np.sort(locations[of_rays == 7, 2]), np.arange(hits) / 2, atol=1e-12)
            self.assertEqual(len(engine.intersects_id(*rays)[0]), 50 * hits)
            for most in (0, 1, 20, 200):
                self.assertEqual(len(engine.intersects_id(*rays, max_hits=most)[0]), 50 * min(most, hits))

    @unittest.skipUnless(trimesh, "no trimesh")
    def test_contains_counts_every_wall(self):
        mesh = plates(60, 3)
        solid = trimesh.Trimesh(mesh.vertices * (100, 100, 1), mesh.faces, process=False)
        self.assertTrue(solid.is_watertight)
        solid.ray = RayMeshIntersector(solid)
        points = np.random.default_rng(4).uniform((0, 0, -1), (300, 300, 61), (2000, 3))
        np.testing.assert_array_equal(solid.contains(points), (points[:, 2] % 1 < 0.5) & (abs(points[:, 2] - 30) < 30))

    def test_closest_points_match_a_search_over_all_triangles(self):
        rng = np.random.default_rng(8)
        for mesh in (sphere(), sphere(rows=6), sphere(scale=1e-3, center=(5e4, -3e5, 10))):
            vertices = np.asarray(mesh.vertices)
            size = np.ptp(vertices, axis=0).max()
            middle = vertices.mean(axis=0)
            points = middle + size * rng.normal(size=(200, 3))
            points[:50] = vertices[:50]
            closest, distances, triangles = ProximityQuery(mesh).on_surface(points)
            corners = vertices[mesh.faces]
            for i, point in enumerate(points):
                to_all = distances_to_triangles(point - middle, corners - middle)
                self.assertAlmostEqual(distances[i] / size, to_all.min() / size, delta=1e-6)
                self.assertAlmostEqual(distances[i] / size, to_all[triangles[i]] / size, delta=1e-9)
            np.testing.assert_allclose(np.linalg.norm(closest - points, axis=1), distances, atol=1e-9 * size)

    def test_closest_points_of_no_triangles_and_of_no_points(self):
        empty = StandIn(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), int))
        closest, distances, triangles = ProximityQuery(empty).on_surface([[1, 2, 3]])
        self.assertTrue(np.isnan(closest).all())
        self.assertEqual((distances[0], triangles[0]), (np.inf, -1))
        self.assertEqual(ProximityQuery(sphere()).on_surface(np.zeros((0, 3)))[0].shape, (0, 3))
        with self.assertRaisesRegex(ValueError, "points"):
            ProximityQuery(sphere()).on_surface([[np.nan, 0, 0]])

    @unittest.skipUnless(trimesh, "requires trimesh")
    def test_signed_distances(self):
        mesh = trimesh.Trimesh(*bumpy_sphere(), process=False)
        points = np.array([[0, 0, 0], [0.1, 0.2, 0.1], [2, 0, 0], [0, -3, 1]])
        signed = ProximityQuery(mesh).signed_distance(points)
        self.assertEqual((signed > 0).tolist(), [True, True, False, False])

    def test_locations_at_triangles_of_no_area_are_on_them(self):
        for rows in (6, 24):
            vertices, faces = bumpy_sphere(rows=rows)
            # Triangles along edges: with the middle of the edge, with equal vertices, and with a vertex next to it.
            a, b, c = vertices[faces].transpose(1, 0, 2)
            n = len(vertices)
            middles = n + np.arange(len(faces))
            slivers = [np.stack([faces[:, 0], middles, faces[:, 1]], axis=-1), faces[:, [0, 1, 1]], faces[:, [2, 2, 2]]]
            needles = np.stack([faces[:, 0], middles + len(faces), faces[:, 1]], axis=-1)
            mesh = StandIn(
                vertices=np.concatenate([vertices, (a + b) / 2, (a + b) / 2 + 1e-9 * (c - a)]),
                faces=np.concatenate([faces, *slivers, needles]),
            )
            engine = RayMeshIntersector(mesh)
            rng = np.random.default_rng(11)
            weights = rng.uniform(0, 1, (len(faces), 1))
            origins = rng.normal(size=(len(faces), 3)) * 3
            hit_flat = 0
            for targets in (weights * a + (1 - weights) * b, (a + b) / 2, c):
                with np.errstate(all="raise"):
                    locations, rays, triangles = engine.intersects_location(origins, targets - origins)
                directions = (targets - origins)[rays]
                directions /= np.linalg.norm(directions, axis=1, keepdims=True)
                along = ((locations - origins[rays]) * directions).sum(axis=1, keepdims=True)
                off = np.linalg.norm(origins[rays] + along * directions - locations, axis=1)
                self.assertLess(off.max(), 1e-12)
                corners = mesh.vertices[mesh.faces[triangles]]
                below, above = corners.min(axis=1) - locations, locations - corners.max(axis=1)
                self.assertLess(np.maximum(below, above).max(), 1e-5)
                hit_flat += (triangles >= len(faces)).sum()
                self.assertEqual(len(np.unique([rays, triangles], axis=1).T), len(rays), "a triangle is hit twice")
            if rows > 10:  # compressed: the kernels hit triangles that are edges, too
                self.assertGreater(hit_flat, 10)

    def test_rays_may_start_far_away(self):
        for rows in (6, 24):
            for scale_to_box in (True, False):
                mesh = sphere(rows=rows)
                origins, directions = rays_at(mesh, 150, seed=8)
                directions /= np.linalg.norm(directions, axis=1, keepdims=True)
                origins -= 10 * directions  # outside of the mesh
                engine = RayMeshIntersector(mesh, scale_to_box=scale_to_box)
                expected = engine.intersects_location(origins, directions)
                self.assertGreater(len(expected[1]), 150)
                for sizes in (1e3, 1e5, 1e6, 1e7):
                    with self.subTest(rows=rows, scale_to_box=scale_to_box, sizes=sizes):
                        away = origins - sizes * directions
                        locations, rays, triangles = engine.intersects_location(away, directions)
                        np.testing.assert_array_equal(rays, expected[1])
                        np.testing.assert_array_equal(triangles, expected[2])
                        np.testing.assert_allclose(locations, expected[0], atol=1e-14 * sizes)

    def test_directions_of_any_length(self):
        mesh = sphere()
        origins, directions = rays_at(mesh, 50, seed=9)
        expected = RayMeshIntersector(mesh).intersects_first(origins, directions)
        for length in (1e-200, 1e-30, 1e30, 1e200):
            found = RayMeshIntersector(mesh).intersects_first(origins, directions * length)
            np.testing.assert_array_equal(found, expected)

    def test_rays_without_a_direction_and_rays_that_are_not_finite_miss(self):
        origins = np.array([[0, 0, 0], [0, 0, 0], [np.nan, 0, 5], [0, np.inf, 5], [0.05, 0.02, 5]])
        directions = np.array([[0, 0, 0], [0, np.nan, 1], [0, 0, -1], [0, 0, -1], [0, 0, -1.0]])
        for rows in (6, 24):
            found = RayMeshIntersector(sphere(rows=rows)).intersects_any(origins, directions)
            self.assertEqual(found.tolist(), [False] * 4 + [True])

    def test_rays_along_axes_hit(self):
        for cells in (1, 3):
            engine = RayMeshIntersector(plates(10, cells))
            origins = [[0.5, 0.2, -5], [0.5, 0.2, 4.75], [-5, 0.2, 0.2], [0.2, -5, 9.4], [0.5, 0.2, 9.6], [5, 5, -5]]
            directions = [[0, 0, 1], [-0.0, 0, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1.0]]
            rays = engine.intersects_id(origins, directions)[1]
            self.assertEqual(np.bincount(rays, minlength=6).tolist(), [20, 10, 2, 2, 0, 0])

    def test_thousands_of_engines_live_at_once(self):
        engines = [RayMeshIntersector(sphere(rows=12)) for _ in range(2200)]
        self.assertGreater(sum(e.memory_bytes() for e in engines), 0)
        self.assertTrue(engines[-1].intersects_any([[0.05, 0.02, 5.0]], [[0.0, 0.0, -1.0]])[0])

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
