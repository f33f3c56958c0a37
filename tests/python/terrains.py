#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Rasters of any size are hit in their own coordinates, as brute force in double precision hits them."""

import os
import tempfile
import threading
import unittest

import numpy as np

import embree_cbvh as cbvh
from brute_force import closest_hits, grid_triangles
from documented_code import documented_code, run_in

NATIONAL = (4_512_345.5, 5_432_109.25)  # an origin as of a national grid


def hills(rows, columns, seed=1):
    """Heights of smooth hills and some noise, in meters."""
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    noise = np.random.default_rng(seed).normal(size=(rows, columns))
    return 300 + 9 * np.sin(row / 7 + 1) * np.cos(column / 5) + 4 * np.sin(column / 23) + 0.2 * noise


def points_of(heights, cell, origin):
    rows, columns = heights.shape
    x, y = np.meshgrid(origin[0] + cell * np.arange(columns), origin[1] - cell * np.arange(rows))
    return np.stack([x, y, heights], -1)


def rays_at(points, count, seed=1, distance=1000.0):
    """From far above and aside towards random places of the raster."""
    rng = np.random.default_rng(seed)
    flat = points.reshape(-1, 3)
    targets = rng.uniform(flat.min(0), flat.max(0), (count, 3))
    directions = rng.normal(size=(count, 3)) * [1, 1, 0.5]
    directions[:, 2] = -np.abs(directions[:, 2]) - 0.1
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return targets - distance * directions, directions


class Hits(unittest.TestCase):
    def test_hits_agree_with_brute_force_within_the_precision(self):
        heights = hills(71, 93)
        for cell, origin, max_error in ((2.0, NATIONAL, None), (0.3, NATIONAL, 0.001), (30.0, (0.0, 0.0), 0)):
            with self.subTest(cell=cell, max_error=max_error):
                terrain = cbvh.terrain(heights, cell, origin, max_error=max_error)
                points = points_of(heights, cell, origin)
                origins, directions = rays_at(points, 2500)
                hits = terrain.intersect(origins, directions)
                t, triangle = closest_hits(origins - points[0, 0], directions, grid_triangles(points - points[0, 0]))
                found = np.isfinite(t)
                self.assertGreater(found.sum(), 1000)
                # A height that moves by e moves a hit by e / |cosine of ray and normal| along the ray. Rays that pass
                # a ridge closer than e may hit another side.
                error = (cell / 128 if max_error is None else max_error) / 2 + 2e-7 * 93 * cell
                corners = grid_triangles(points)[triangle[found]]
                normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                normals /= np.linalg.norm(normals, axis=1, keepdims=True)
                self.assertLess((hits.hit != found).sum(), 8)
                both = hits.hit[found]
                slope = np.abs((normals * directions[found]).sum(-1))[both]
                off = np.abs(hits.t[found] - t[found])[both]
                self.assertLess((off > 1.5 * error / slope).sum(), 8)
                where = hits.hit
                np.testing.assert_allclose(
                    hits.position[where], origins[where] + hits.t[where, None] * directions[where], rtol=0, atol=1e-6
                )
                np.testing.assert_allclose(np.linalg.norm(hits.normal[where], axis=1), 1, atol=1e-5)
                self.assertTrue((hits.normal[where, 2] > 0).all())
                agrees = (hits.normal[found][both] * normals[both] * np.sign(normals[both, 2:])).sum(-1)
                self.assertGreater(np.median(agrees), 0.9999)
                np.testing.assert_array_equal(terrain.occluded(origins, directions), hits.hit)

    def test_samples_are_where_the_georeference_places_them(self):
        heights = hills(20, 30)
        terrain = cbvh.terrain(heights, 2.0, NATIONAL)
        self.assertEqual(terrain.shape, (20, 30))
        self.assertEqual(terrain.cell, (2.0, -2.0))
        row, column = np.meshgrid(np.arange(20), np.arange(30), indexing="ij")
        above = points_of(heights, 2.0, NATIONAL) + [0, 0, 50]
        inside = above[1:-1, 1:-1]
        hits = terrain.intersect(inside, [0, 0, -1])
        self.assertEqual(hits.t.dtype, np.float64)
        np.testing.assert_allclose(hits.t, 50, atol=1 / 128 + 1e-4)
        np.testing.assert_array_equal(hits.position[..., :2], inside[..., :2])
        np.testing.assert_allclose(hits.row, row[1:-1, 1:-1], atol=1e-9)
        np.testing.assert_allclose(hits.column, column[1:-1, 1:-1], atol=1e-9)
        np.testing.assert_allclose(terrain.bounds[0, :2], [NATIONAL[0], NATIONAL[1] - 38], atol=1e-9)
        np.testing.assert_allclose(terrain.bounds[:, 2], [heights.min(), heights.max()], atol=0.01)

    def test_southward_and_oblong_cells(self):
        heights = hills(40, 25)
        terrain = cbvh.terrain(heights, (2, 3), (10, 20, 100), max_error=0)
        x, y = np.meshgrid(10 + 2 * np.arange(25), 20 + 3 * np.arange(40))
        points = np.stack([x, y, heights + 100], -1).astype(np.float64)
        origins, directions = rays_at(points, 800)
        t, _ = closest_hits(origins, directions, grid_triangles(points))
        hits = terrain.intersect(origins, directions)
        self.assertEqual((hits.hit != np.isfinite(t)).sum(), 0)
        np.testing.assert_allclose(hits.t[hits.hit], t[hits.hit], atol=2e-3)

    def test_distances_have_limits(self):
        terrain = cbvh.terrain(np.zeros((10, 10)), 1, NATIONAL, max_error=0)
        origin = [NATIONAL[0] + 4.3, NATIONAL[1] - 4.4, 1000]
        hits = terrain.intersect(origin, [0, 0, -2], [0, 0, 501, 0], [np.inf, 499, np.inf, 501])
        np.testing.assert_array_equal(hits.t, [500, np.inf, np.inf, 500])
        self.assertEqual(hits.hit.tolist(), [True, False, False, True])
        self.assertTrue(np.isnan(hits.position[1]).all())
        self.assertTrue(np.isnan(hits.row[1]))
        near = terrain.occluded(origin, [[0, 0, -1], [0, 0, -1e-9], [0, 0, -1e9], [0, 0, 1]], 0, [999, 2e12, 1, np.inf])
        self.assertEqual(near.tolist(), [False, True, True, False])

    def test_heights_may_be_coarse_floats(self):
        terrain = cbvh.terrain(np.full((9, 9), 1e9), 1, max_error=0)
        self.assertTrue(terrain.intersect([4.3, -4.4, 1e12], [0, 0, -1]).hit)
        self.assertTrue(terrain.intersect([4.3, -4.4, 0], [0, 0, 1]).hit)

    def test_threads_return_the_same_bits(self):
        heights = hills(60, 60)
        terrain = cbvh.terrain(heights, 2, NATIONAL)
        rays = rays_at(points_of(heights, 2, NATIONAL), 20000)
        expected = terrain.intersect(*rays, threads=1)
        results = {}

        def work(name):
            results[name] = terrain.intersect(*rays, threads=name % 3)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(results), 6)
        for hits in results.values():
            self.assertEqual(hits.t.tobytes(), expected.t.tobytes())
            self.assertEqual(hits.normal.tobytes(), expected.normal.tobytes())


class Tiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.heights = hills(1500, 2100).astype(np.float32)  # 2 x 3 tiles
        cls.terrain = cbvh.terrain(cls.heights, 0.3, NATIONAL)

    def test_no_sample_is_cut(self):
        self.assertEqual(self.terrain.statistics()["quads"], 1499 * 2099)
        self.assertEqual(self.terrain.shape, (1500, 2100))
        corners = points_of(self.heights, 0.3, NATIONAL)[[0, 0, -1, -1], [0, -1, 0, -1]]
        inward = np.array([[1, -1, 0], [-1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.01
        self.assertTrue(self.terrain.intersect(corners + inward + [0, 0, 9], [0, 0, -1]).hit.all())

    def test_rays_at_borders_of_tiles_hit(self):
        rng = np.random.default_rng(1)
        count = 20000
        aim = np.stack([rng.uniform(100, 2000, count), rng.uniform(100, 1400, count)], -1)
        aim[: count // 2, 0] = rng.choice([1024, 2048], count // 2)
        aim[count // 2 :, 1] = 1024
        aim[::5] = np.stack([rng.choice([1024, 2048], count // 5), np.full(count // 5, 1024)], -1)  # corners
        targets = np.stack([NATIONAL[0] + 0.3 * aim[:, 0], NATIONAL[1] - 0.3 * aim[:, 1], np.full(count, 300.0)], -1)
        directions = rng.normal(size=(count, 3)) * [0.3, 0.3, 0] + [0, 0, -1]
        directions[::2, :2] = 0
        hits = self.terrain.intersect(targets - 40 * directions, directions)
        self.assertEqual((~hits.hit).sum(), 0)
        self.assertLess(np.abs(hits.position[:, 2] - 300).max(), 30)
        self.assertTrue(self.terrain.occluded(targets - 40 * directions, directions).all())

    def test_files_return_the_same_hits(self):
        rays = rays_at(points_of(self.heights, 0.3, NATIONAL), 5000)
        expected = self.terrain.intersect(*rays)
        self.assertGreater(expected.hit.sum(), 1000)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "hills.cbvh")
            self.terrain.save(path)
            loaded = cbvh.Terrain.load(path)
            hits = loaded.intersect(*rays)
            for name in ("t", "position", "normal", "row", "column"):
                np.testing.assert_array_equal(getattr(hits, name), getattr(expected, name))
            self.assertEqual(loaded.origin, self.terrain.origin)
            self.assertEqual(loaded.statistics()["quads"], 1499 * 2099)
            loaded.save(path + "2")
            np.testing.assert_array_equal(cbvh.Terrain.load(path + "2").intersect(*rays).t, expected.t)
            os.remove(path + ".json")
            with self.assertRaisesRegex(cbvh.Error, r"hills\.cbvh\.json: .*Terrain\.save"):
                cbvh.Terrain.load(path)
            with open(path + ".json", "w", encoding="ascii") as file:
                file.write('{"rows": 3}')
            with self.assertRaisesRegex(cbvh.Error, "not a georeference"):
                cbvh.Terrain.load(path)

    def test_parts_are_written_to_a_file_as_they_are_built(self):
        rays = rays_at(points_of(self.heights, 0.3, NATIONAL), 5000)
        expected = self.terrain.intersect(*rays)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "hills.cbvh")
            terrain = cbvh.terrain(self.heights, 0.3, NATIONAL, path=path)
            self.assertEqual(sorted(os.listdir(folder)), ["hills.cbvh", "hills.cbvh.json"])
            tiles = cbvh.Terrain.load(path, representation="ctile")
            built = cbvh.terrain(self.heights, 0.3, NATIONAL, path=path + "2", representation="ctile")
            for tiled in (tiles, built):  # in memory
                self.assertGreater(tiled.statistics()["live_bytes"], 4 * 1499 * 2099)
            self.assertLess(terrain.statistics()["live_bytes"], 1499 * 2099)
            for scene in (terrain, cbvh.Terrain.load(path), tiles, built):
                hits = scene.intersect(*rays)
                np.testing.assert_array_equal(hits.t, expected.t)
                np.testing.assert_array_equal(hits.normal, expected.normal)
            with self.assertRaisesRegex(ValueError, "representation: .*'cvert'"):
                cbvh.Terrain.load(path, representation="cleaf")
            with self.assertRaisesRegex(cbvh.Error, "none"):
                cbvh.terrain(self.heights, path=os.path.join(folder, "none", "hills"))

    def test_memory_maps_and_other_rasters_are_read_by_parts(self):
        rays = rays_at(points_of(self.heights, 0.3, NATIONAL), 2000)
        expected = self.terrain.intersect(*rays).t

        class Dataset:
            shape, most = self.heights.shape, 0

            def __getitem__(dataset, key):
                part = self.heights[key]
                Dataset.most = max(Dataset.most, part.size)
                return part

        with tempfile.NamedTemporaryFile() as file:
            self.heights.tofile(file.name)
            mapped = np.memmap(file.name, np.float32, "r", shape=self.heights.shape)
            for raster in (mapped, Dataset(), self.heights.astype(np.float64)):
                np.testing.assert_array_equal(cbvh.terrain(raster, 0.3, NATIONAL).intersect(*rays).t, expected)
        self.assertEqual(Dataset.most, 1025**2)

    def test_progress_is_reported_and_stops_the_build(self):
        reported = []
        cbvh.terrain(self.heights, progress=lambda phase, done: reported.append((phase, done)))
        self.assertEqual([r[0] for r in reported], ["terrain"] * 7)
        self.assertEqual((reported[0][1], reported[-1][1]), (0, 1))

        def stop(_, done):
            if done > 0:
                raise LookupError("enough")

        with self.assertRaisesRegex(LookupError, "enough"):
            cbvh.terrain(self.heights, progress=stop)


class Samples(unittest.TestCase):
    def test_example_of_the_documentation_traces_a_raster(self):
        code = documented_code("docs/terrain.md", 0)
        heights = hills(6000 // 8, 9000 // 8).astype(np.float32)
        with tempfile.TemporaryDirectory() as folder:
            heights.tofile(os.path.join(folder, "heights.f32"))
            code = code.replace("(6000, 9000)", str(heights.shape)).replace("cell=2", "cell=16")
            names = run_in(folder, code)
            hits, loaded = names["hits"], cbvh.Terrain.load(os.path.join(folder, "heights.cbvh"))
        self.assertTrue(hits.hit)
        expected = heights[int(round(float(hits.row))), int(round(float(hits.column)))]
        self.assertAlmostEqual(float(hits.position[2]), expected, delta=5)
        self.assertEqual(loaded.intersect([4_520_000, 5_425_000, 3000], [0.1, 0.2, -1]).t, hits.t)

    def test_missing_samples_are_holes(self):
        heights = hills(30, 30)
        heights[4, 5], heights[20, 20] = np.nan, -9999
        terrain = cbvh.terrain(heights, nodata=-9999)
        self.assertEqual(terrain.statistics()["compression"]["invalid_quads"], 8)
        hit = terrain.intersect([[4.9, -3.9, 999], [20.1, -20.1, 999], [10.5, -10.5, 999]], [0, 0, -1]).hit
        self.assertEqual(hit.tolist(), [False, False, True])

    def test_tiles_without_samples_are_holes(self):
        heights = np.full((1100, 1100), np.nan)
        heights[1050:1060, 1050:1060] = 3
        terrain = cbvh.terrain(heights)
        self.assertEqual(
            terrain.intersect([[5.5, -5.5, 9], [1055.5, -1055.5, 9]], [0, 0, -1]).hit.tolist(), [False, True]
        )

    def test_integers_are_exact(self):
        heights = np.random.default_rng(1).integers(-100, 3000, (50, 60)).astype(np.int16)
        terrain = cbvh.terrain(heights, 30)
        x, y = np.meshgrid(30.0 * np.arange(1, 59), -30.0 * np.arange(1, 49))
        hits = terrain.intersect(np.stack([x, y, np.full_like(x, 5000)], -1), [0, 0, -1])
        np.testing.assert_array_equal(hits.position[..., 2], heights[1:-1, 1:-1])

    def test_invalid_input_is_reported_by_name(self):
        heights = np.zeros((4, 5))
        terrain = cbvh.terrain(heights)
        infinite = heights.copy()
        infinite[2, 3] = np.inf
        for error, text, call in (
            (ValueError, r"heights: .*\(5,\).*2 to", lambda: cbvh.terrain(heights[0])),
            (ValueError, r"heights: .*\(1, 5\)", lambda: cbvh.terrain(heights[:1])),
            (ValueError, "heights: row 2, column 3 is inf", lambda: cbvh.terrain(infinite)),
            (ValueError, "heights: .*missing", lambda: cbvh.terrain(heights * np.nan)),
            (TypeError, "heights: .*complex", lambda: cbvh.terrain(heights * 1j)),
            (ValueError, "heights: .*mask", lambda: cbvh.terrain(np.ma.masked_equal(heights, 0))),
            (ValueError, "cell: .*0", lambda: cbvh.terrain(heights, 0)),
            (ValueError, "cell: .*-1", lambda: cbvh.terrain(heights, -1)),
            (ValueError, r"cell: .*\(3,\)", lambda: cbvh.terrain(heights, (1, 2, 3))),
            (ValueError, r"origin: .*\(1,\)", lambda: cbvh.terrain(heights, 1, [3])),
            (ValueError, "origin: .*finite", lambda: cbvh.terrain(heights, 1, (0, np.nan))),
            (ValueError, "max_error: .*-1", lambda: cbvh.terrain(heights, max_error=-1)),
            (ValueError, "representation: .*'grid'", lambda: cbvh.terrain(heights, representation="grid")),
            (TypeError, "progress: .*callable", lambda: cbvh.terrain(heights, progress=3)),
            (
                ValueError,
                "directions: ray 1 has length 0",
                lambda: terrain.intersect([0, 0, 1], [[0, 0, 1], [0, 0, 0]]),
            ),
            (ValueError, "origins: ray 0 is not finite", lambda: terrain.intersect([0, np.inf, 1], [0, 0, 1])),
            (ValueError, r"origins: .*\(2,\)", lambda: terrain.occluded([0, 0], [0, 0, 1])),
            (ValueError, "threads: .*-1", lambda: terrain.intersect([0, 0, 1], [0, 0, 1], threads=-1)),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                call()


if __name__ == "__main__":
    unittest.main()
