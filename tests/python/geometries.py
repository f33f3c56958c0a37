#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes of cages, grids and meshes are hit where brute force hits their triangles, by ID, also from files."""

import os
import tempfile
import threading
import unittest

import numpy as np

import embree_cbvh as cbvh
from brute_force import closest_hits, grid_triangles
from documented_code import documented_code, run_in
from sheets import bumpy_model, sheet, sheet_arrays
from triangle_distances import distances_to_triangles

MISS = 2**32 - 1


def waves(rows, columns, lower=0.0):
    """(rows, columns, 3) points above the unit square, with different heights everywhere."""
    y, x = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    return np.stack([x, y, lower + 0.1 * np.sin(9 * x + 1) * np.cos(7 * y)], -1)


def mixed_geometries():
    """Four sheets above each other, from above: quads, triangles, a grid and a subdivision surface."""
    vertices, quads = sheet_arrays(9)
    vertices = vertices + [0, 0, 3] + 0.02 * np.sin(17 * vertices[:, :1]) * [0, 0, 1]
    triangles = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    return [
        cbvh.Grid(waves(40, 30, 1), max_error=1e-4),
        cbvh.Mesh(vertices + [0, 0, -1], triangles, max_error=0),
        cbvh.Subdivision(bumpy_model(), level=4),
        cbvh.Mesh(vertices, quads),
    ]


def random_rays(count, seed=1):
    """From all sides towards the box of the mixed geometries; some miss."""
    rng = np.random.default_rng(seed)
    targets = rng.uniform([0, 0, -0.1], [1, 1, 3.1], (count, 3))
    origins = rng.normal(size=(count, 3))
    origins = [0.5, 0.5, 1.5] + 6 * origins / np.linalg.norm(origins, axis=1, keepdims=True)
    return origins.astype(np.float32), (targets - origins).astype(np.float32)


def stored_triangles(scene, time=0):
    """(n, 3, 3) float64 corners, and geomID of each."""
    mesh = scene.stored_mesh(time=time)
    corners = mesh["vertices"][mesh["quads"][:, [[0, 1, 3], [3, 1, 2]]].reshape(-1, 3)].astype(np.float64)
    return corners, np.repeat(mesh["geomID"], 2)


class Mixed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = cbvh.Scene(mixed_geometries())
        cls.rays = random_rays(4000)
        cls.hits = cls.scene.intersect(*cls.rays)

    def test_hits_are_those_of_the_stored_triangles(self):
        corners, geometry = stored_triangles(self.scene)
        t, triangle = closest_hits(*self.rays, corners)
        found = np.isfinite(t)
        self.assertGreater(found.sum(), 2000)
        self.assertLess(found.sum(), 4000)
        np.testing.assert_array_equal(self.hits.hit, found)
        np.testing.assert_allclose(self.hits.t[found], t[found], rtol=2e-6)
        same = self.hits.geomID[found] == geometry[triangle[found]]
        self.assertEqual((~same).sum(), 0)
        self.assertEqual(sorted(set(self.hits.geomID[found])), [0, 1, 2, 3])
        self.assertTrue((self.hits.geomID[~found] == MISS).all())
        np.testing.assert_array_equal(self.scene.occluded(*self.rays), found)

    def test_stored_triangles_are_within_the_precision(self):
        corners, geometry = stored_triangles(self.scene)
        grid = grid_triangles(waves(40, 30, 1)).reshape(-1, 3)
        stored = corners[geometry == 0].reshape(-1, 3)
        lookup = {tuple(np.round(v[:2] * [29, 39]).astype(int)): v for v in stored}
        self.assertEqual(len(lookup), 40 * 30)
        moved = [np.abs(v - lookup[tuple(np.round(v[:2] * [29, 39]).astype(int))]).max() for v in grid]
        self.assertLessEqual(max(moved), 0.5e-4 + 1e-7)
        vertices, _ = sheet_arrays(9)
        vertices = (vertices + [0, 0, 2] + 0.02 * np.sin(17 * vertices[:, :1]) * [0, 0, 1]).astype(np.float32)
        exact = set(map(tuple, corners[geometry == 1].reshape(-1, 3).tolist()))
        self.assertEqual(exact, set(map(tuple, vertices.astype(np.float64).tolist())))

    def test_primitives_are_the_faces_of_each_geometry(self):
        x, y = np.meshgrid((np.arange(9) + 0.4) / 9, (np.arange(9) + 0.3) / 9)
        down = np.array([0, 0, -1], np.float32)
        for geometry, height, expected in (
            (3, 9.0, np.arange(81).reshape(9, 9)),
            (1, 2.5, 2 * np.arange(81).reshape(9, 9)),
        ):
            hits = self.scene.intersect(np.stack([x, y, np.full_like(x, height)], -1), down)
            np.testing.assert_array_equal(hits.geomID, geometry)
            np.testing.assert_array_equal(hits.primID, expected)
        hits = self.scene.intersect(np.stack([x, y, np.full_like(x, 1.5)], -1), down)
        np.testing.assert_array_equal(hits.geomID, 0)
        np.testing.assert_array_equal(hits.primID, 0)
        np.testing.assert_allclose(hits.u, x, atol=1e-3)
        np.testing.assert_allclose(hits.v, y, atol=1e-3)

    def test_triangles_contain_their_hits(self):
        triangles = self.scene.triangles(self.hits).astype(np.float64)
        np.testing.assert_array_equal(np.isnan(triangles).any((1, 2)), ~self.hits.hit)
        where = self.hits.hit
        origins, directions = (a[where].astype(np.float64) for a in self.rays)
        points = origins + self.hits.t[where, None] * directions
        for point, triangle in list(zip(points, triangles[where]))[:500]:
            self.assertLess(distances_to_triangles(point, triangle[None])[0], 1e-5)

    def test_closest_points_equal_those_of_the_stored_triangles(self):
        corners, geometry = stored_triangles(self.scene)
        points = np.random.default_rng(3).uniform([0, 0, -0.5], [1, 1, 3.5], (60, 3)).astype(np.float32)
        positions, hits = self.scene.closest_points(points)
        for i, point in enumerate(points):
            distances = distances_to_triangles(point.astype(np.float64), corners)
            self.assertAlmostEqual(hits.t[i], distances.min(), delta=2e-6)
            self.assertAlmostEqual(distances[geometry == hits.geomID[i]].min(), distances.min(), delta=1e-9)
            self.assertAlmostEqual(np.linalg.norm(positions[i] - point), hits.t[i], delta=2e-6)

    def test_files_return_the_same_hits(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "mixed.cbvh")
            self.scene.save(path)
            loaded = cbvh.load(path)
            hits = loaded.intersect(*self.rays)
            for name in ("t", "u", "v", "Ng", "primID", "geomID"):
                np.testing.assert_array_equal(getattr(hits, name), getattr(self.hits, name))
            np.testing.assert_array_equal(loaded.occluded(*self.rays), self.hits.hit)
            np.testing.assert_array_equal(loaded.triangles(hits), self.scene.triangles(self.hits))
            for mine, theirs in zip(
                loaded.closest_points(self.rays[0][:50]), self.scene.closest_points(self.rays[0][:50])
            ):
                mine, theirs = (a if isinstance(a, np.ndarray) else a.geomID for a in (mine, theirs))
                np.testing.assert_array_equal(mine, theirs)
            self.assertEqual(loaded.geometries, 4)
            self.assertEqual(loaded.statistics()["quads"], self.scene.statistics()["quads"])
            loaded.save(path + "2")
            np.testing.assert_array_equal(cbvh.load(path + "2").intersect(*self.rays).t, self.hits.t)

    def test_statistics_count_all_geometries(self):
        s = self.scene.statistics()
        self.assertEqual(s["quads"], 39 * 29 + 81 + 25 * 16**2 + 81)
        self.assertEqual(s["compression"]["quads"], s["quads"])
        self.assertEqual(s["representation"], "cTILE")
        self.assertRegex(repr(self.scene), "<Scene in cTILE: 4 geometries, .* quads>")
        np.testing.assert_allclose(self.scene.bounds[:, :2], [[0, 0], [1, 1]], atol=0.1)

    def test_threads_return_the_same_bits(self):
        results = {}

        def work(name):
            results[name] = [self.scene.intersect(*self.rays, threads=1 + name % 2) for _ in range(3)]

        threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(results), 4)
        for name in ("t", "u", "v", "Ng", "primID", "geomID"):
            expected = getattr(self.hits, name).tobytes()
            for hits in sum(results.values(), []):
                self.assertEqual(getattr(hits, name).tobytes(), expected)

    def test_cvert_has_the_same_hits(self):
        hits = cbvh.Scene(mixed_geometries(), "cvert").intersect(*self.rays)
        np.testing.assert_array_equal(hits.t, self.hits.t)
        np.testing.assert_array_equal(hits.geomID, self.hits.geomID)


class Documented(unittest.TestCase):
    def test_example_of_the_documentation_runs(self):
        names = run_in(os.curdir, documented_code("docs/programs.md", 1))
        self.assertEqual((names["hits"].geomID, names["hits"].primID), (2, 0))
        self.assertEqual(names["scene"].geometries, 4)


class Motion(unittest.TestCase):
    def test_grids_and_meshes_move(self):
        points = waves(20, 30)
        vertices, quads = sheet_arrays(4)
        rise = np.array([0, 0, 0.5])
        scene = cbvh.Scene(
            [
                cbvh.Grid(np.stack([points, points + rise]), max_error=1e-5),
                cbvh.Mesh(np.stack([vertices + 2 * rise, vertices + 3 * rise, vertices + 4 * rise]), quads),
                cbvh.Grid.from_heights(
                    np.stack([np.zeros((5, 5)), np.ones((5, 5))]), (0.25, 0.25), (0, 0, 3), times=(0, 0.5)
                ),
            ]
        )
        for geometry, height, start, speed in ((1, 2.5, 1, 1), (2, 4.5, 3, 2)):
            for time in (0, 0.25, 0.4):
                hits = scene.intersect([0.4, 0.3, height], [0, 0, -1], time=time)
                self.assertEqual(hits.geomID, geometry)
                self.assertAlmostEqual(height - hits.t, start + speed * time, delta=1e-4)
        self.assertEqual(scene.intersect([0.4, 0.3, 4.5], [0, 0, -1], time=0.75).geomID, 1)  # the last one is absent
        rays = np.random.default_rng(1).uniform(0.05, 0.95, (300, 3)) * [1, 1, 0] + [0, 0, 0.9]
        hits = scene.intersect(rays, [0, 0, -1], time=0.5)
        t, _ = closest_hits(rays, np.broadcast_to([0.0, 0, -1], rays.shape), grid_triangles(points + 0.5 * rise))
        np.testing.assert_allclose(hits.t, t, atol=3e-5)

    def test_steps_are_reported(self):
        self.assertEqual(cbvh.Grid(np.zeros((7, 3, 3, 3))).steps, 7)
        self.assertEqual(repr(cbvh.Grid(np.zeros((7, 3, 4, 3)))), "<grid of 3 x 4 points, 7 time steps>")
        self.assertEqual(cbvh.Subdivision(sheet()).steps, 1)


class Arrays(unittest.TestCase):
    def hits(self, geometry):
        return cbvh.Scene([geometry]).intersect(*random_rays(500)).t

    def test_layouts_give_the_same_scene(self):
        points = waves(20, 30, 1).astype(np.float32)
        padded = np.zeros((20, 30, 4), np.float32)
        padded[..., :3] = points
        expected = self.hits(cbvh.Grid(points))
        self.assertTrue(np.isfinite(expected).any())
        for other in (
            points.astype(np.float64),
            np.asfortranarray(points),
            padded[..., :3],
            np.repeat(points, 2, 0)[::2],
            np.repeat(points, 3, 1)[:, ::3],
            points[::-1, ::-1][::-1, ::-1],
            points.astype(">f4"),
            points.tolist(),
        ):
            np.testing.assert_array_equal(self.hits(cbvh.Grid(other)), expected)

    def test_indices_of_any_type_give_the_same_scene(self):
        vertices, quads = sheet_arrays(6)
        expected = self.hits(cbvh.Mesh(vertices, quads))
        for dtype in (np.uint8, np.int16, np.int32, np.uint32, np.int64, np.uint64, ">i4"):
            np.testing.assert_array_equal(self.hits(cbvh.Mesh(vertices, quads.astype(dtype))), expected)
        np.testing.assert_array_equal(self.hits(cbvh.Mesh(vertices, np.asfortranarray(quads))), expected)

    def test_arrays_at_the_end_of_a_page_are_safe(self):
        with tempfile.NamedTemporaryFile() as file:
            points = np.memmap(file.name, np.float32, "w+", shape=(32, 32, 3))  # 3 pages
            points[:] = waves(32, 32, 1)
            self.assertEqual(points.nbytes % 4096, 0)
            expected = self.hits(cbvh.Grid(np.array(points)))
            np.testing.assert_array_equal(self.hits(cbvh.Grid(points)), expected)

    def test_heights_are_placed_by_cell_and_origin(self):
        heights = waves(12, 9)[..., 2].astype(np.float32)
        points = np.stack([*np.meshgrid(2 + 0.5 * np.arange(9), 7 - 0.25 * np.arange(12)), 10 + heights], -1)
        rng = np.random.default_rng(1)
        origins = np.stack([rng.uniform(2, 6, 500), rng.uniform(4.3, 7, 500), np.full(500, 20)], -1)
        scenes = [
            cbvh.Scene([g]) for g in (cbvh.Grid(points), cbvh.Grid.from_heights(heights, (0.5, -0.25), (2, 7, 10)))
        ]
        a, b = (s.intersect(origins, [0, 0, -1]) for s in scenes)
        np.testing.assert_array_equal(a.t, b.t)
        np.testing.assert_array_equal(a.u, b.u)
        self.assertTrue(a.hit.all())

    def test_rows_go_south_as_in_terrains(self):
        rng = np.random.default_rng(1)
        heights = rng.uniform(0, 1, (20, 30))
        inside = np.stack([rng.uniform(0.1, 57.9, 500), rng.uniform(-37.9, -0.1, 500), np.full(500, 9)], -1)
        for cell in (2, (2, -2), np.float32(2), [2.0]):
            grid = cbvh.Scene([cbvh.Grid.from_heights(heights, cell, max_error=0)]).intersect(inside, [0, 0, -1])
            terrain = cbvh.terrain(heights, cell, max_error=0).intersect(inside, [0, 0, -1])
            self.assertTrue(grid.hit.all() and terrain.hit.all())
            np.testing.assert_allclose(grid.t, terrain.t, atol=1e-5)
            self.assertTrue((grid.Ng[:, 2] < 0).all())
        self.assertFalse(cbvh.Scene([cbvh.Grid.from_heights(heights)]).intersect([9, 9, 9], [0, 0, -1]).hit)

    def test_missing_heights_are_holes(self):
        heights = np.zeros((10, 10))
        heights[4, 5] = np.nan
        scene = cbvh.Scene([cbvh.Grid.from_heights(heights, (1, 1))])
        x, y = np.meshgrid(np.arange(9) + 0.25, np.arange(9) + 0.25)
        lower, upper = (scene.intersect(np.stack([x + d, y + d, 1 + 0 * x], -1), [0, 0, -1]).hit for d in (0, 0.5))
        self.assertEqual(np.argwhere(~lower).tolist(), [[3, 5], [4, 4], [4, 5]])
        self.assertEqual(np.argwhere(~upper).tolist(), [[3, 4], [3, 5], [4, 4]])
        self.assertEqual(scene.statistics()["compression"]["invalid_quads"], 4)

    def test_invalid_input_is_reported_by_name(self):
        vertices, quads = sheet_arrays(2)
        hole = waves(3, 4)
        hole[1, 2, 0] = np.nan
        broken = vertices.copy()
        broken[5, 1] = np.inf
        heights = np.zeros((3, 3))
        for error, text, call in (
            (ValueError, r"points: .*\(3, 4\).*\(rows, columns, 3\)", lambda: cbvh.Grid(np.zeros((3, 4)))),
            (ValueError, r"points: .*\(3, 4, 2\)", lambda: cbvh.Grid(np.zeros((3, 4, 2)))),
            (ValueError, "points: has 1 row and 4 columns: .*2 to 65535", lambda: cbvh.Grid(np.zeros((1, 4, 3)))),
            (ValueError, "points: .*70000 columns", lambda: cbvh.Grid(np.zeros((2, 70000, 3), np.float32))),
            (ValueError, "points: row 1, column 2 is not finite", lambda: cbvh.Grid(hole)),
            (ValueError, "points: time step 1, row 1, column 2", lambda: cbvh.Grid([waves(3, 4), hole])),
            (ValueError, "points: has 130 time steps", lambda: cbvh.Grid(np.zeros((130, 2, 2, 3)))),
            (ValueError, "points: row 0, column 0 is not finite", lambda: cbvh.Grid([[[1e39, 0, 0]] * 2] * 2)),
            (TypeError, "points: .*complex128", lambda: cbvh.Grid(np.zeros((2, 2, 3), complex))),
            (ValueError, "points: .*mask", lambda: cbvh.Grid(np.ma.masked_equal(np.zeros((2, 2, 3)), 0))),
            (ValueError, r"vertices: .*\(9, 2\).*\(n, 3\)", lambda: cbvh.Mesh(vertices[:, :2], quads)),
            (ValueError, "vertices: row 5 is not finite", lambda: cbvh.Mesh(broken, quads)),
            (ValueError, r"indices: .*\(4, 2\).*\(n, 3\).*\(n, 4\)", lambda: cbvh.Mesh(vertices, quads[:, :2])),
            (ValueError, "indices: face 0 has index 9: expected 0 to 8", lambda: cbvh.Mesh(vertices, [[0, 1, 9]])),
            (ValueError, "indices: face 1 has index -1", lambda: cbvh.Mesh(vertices, [[0, 1, 2], [0, -1, 2]])),
            (
                ValueError,
                "indices: face 0 has index -2",
                lambda: cbvh.Mesh(vertices, np.array([[0, 1, -2]], np.int32)),
            ),
            (ValueError, "indices: .*no faces", lambda: cbvh.Mesh(vertices, np.zeros((0, 3), int))),
            (TypeError, "indices: .*float64.*integers", lambda: cbvh.Mesh(vertices, quads * 1.0)),
            (ValueError, "max_error: .*-1", lambda: cbvh.Mesh(vertices, quads, max_error=-1)),
            (ValueError, "max_error: .*nan", lambda: cbvh.Grid(waves(3, 3), max_error=np.nan)),
            (ValueError, "times: .*first one below", lambda: cbvh.Grid(waves(3, 3), times=(1, 1))),
            (ValueError, r"heights: .*\(3,\)", lambda: cbvh.Grid.from_heights([1, 2, 3])),
            (ValueError, "heights: .*infinite", lambda: cbvh.Grid.from_heights(heights + np.inf)),
            (ValueError, "cell: is 0: .*above 0", lambda: cbvh.Grid.from_heights(heights, 0)),
            (ValueError, "cell: is -2: .*above 0", lambda: cbvh.Grid.from_heights(heights, -2)),
            (ValueError, r"origin: .*\(2,\).*\(3,\)", lambda: cbvh.Grid.from_heights(heights, 1, (1, 2))),
            (cbvh.Error, "^level 9 ", lambda: cbvh.Subdivision(sheet(), 9)),
            (TypeError, "geometries: item 1 is a int", lambda: cbvh.Scene([sheet(), 3])),
            (ValueError, "geometries: .*empty", lambda: cbvh.Scene([])),
            (ValueError, "representation: .*'cleaf'.*'ctile' or 'cvert'", lambda: cbvh.Scene([sheet()], "cleaf")),
            (cbvh.Error, "isa 'neon'", lambda: cbvh.Scene([sheet()], isa="neon")),
        ):
            with self.subTest(text), np.errstate(over="ignore"), self.assertRaisesRegex(error, text):
                call()
        a, b = cbvh.Scene([cbvh.Grid(waves(3, 3))]), cbvh.Scene([sheet()])
        with self.assertRaisesRegex(ValueError, "hits: .*25 faces: expected 1"):
            a.triangles(b.intersect(*random_rays(3)))


if __name__ == "__main__":
    unittest.main()
