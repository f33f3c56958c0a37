#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""All hits of rays are those that closest hits find one after the other."""

import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import bumpy_model


def walls(count):
    """Squares of 2 x 2 at z = 0, 1, ..., count - 1, as quads in any order."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    vertices = np.concatenate([corners + np.float32([0, 0, z]) for z in range(count)])
    quads = np.arange(4 * count).reshape(count, 4)
    return cbvh.Mesh(vertices, np.random.default_rng(3).permutation(quads))


def through(count, seed=1):
    rng = np.random.default_rng(seed)
    ends = rng.normal(size=(2, count, 3))
    ends /= np.linalg.norm(ends, axis=-1, keepdims=True)
    return (ends[0] * 3).astype(np.float32), (ends[1] - ends[0] * 3).astype(np.float32)


class AllHits(unittest.TestCase):
    def check(self, scene, origins, directions, **options):
        hits, rays = scene.all_hits(origins, directions, **options)
        self.assertEqual((hits.shape, rays.dtype), (rays.shape, np.int64))
        self.assertTrue(hits.hit.all())
        order = np.lexsort([hits.t, rays])
        np.testing.assert_array_equal(order, np.arange(len(rays)))
        found = {(r, t, g, p) for r, t, g, p in zip(rays, hits.t, hits.geomID, hits.primID)}
        # Closest hits behind the one before. Of several at the same distance, as at an edge, one is found.
        tnear, active, steps = np.zeros(len(origins), np.float32), np.arange(len(origins)), 0
        last = np.zeros(len(origins), int)
        while len(active):
            closest = scene.intersect(origins[active], directions[active], tnear[active], **options)
            active, t = active[closest.hit], closest.t[closest.hit]
            ids = closest.geomID[closest.hit], closest.primID[closest.hit]
            for hit in zip(active, t, *ids):
                self.assertIn(hit, found)
            tnear[active] = np.nextafter(t, np.float32(np.inf))
            last[active] += 1
            steps += 1
        self.assertGreater(steps, 3)
        self.assertLess(len(rays) - last.sum(), len(origins) // 50 + 1)  # more at edges only
        return hits, rays

    def test_they_are_closest_hits_one_after_the_other(self):
        rng = np.random.default_rng(2)
        sphere = rng.normal(size=(400, 3))
        sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
        soup = cbvh.Mesh(sphere, rng.integers(0, 400, (900, 3)))
        for representation in ("ctile", "cvert"):
            for max_error in (None, 0):
                mesh = cbvh.Mesh(sphere, rng.integers(0, 400, (900, 3)), max_error=max_error)
                scene = cbvh.Scene([soup, mesh, bumpy_model()], representation)
                with self.subTest(representation=representation, max_error=max_error):
                    self.check(scene, *through(300))

    def test_they_do_not_depend_on_threads_or_shapes(self):
        scene = cbvh.Scene([walls(40)])
        origins = np.random.default_rng(5).uniform(-1, 1, (50, 60, 3)) * [1, 1, 0] - [0, 0, 2]
        expected, rays = scene.all_hits(origins, [0, 0, 1], threads=1)
        self.assertEqual(np.bincount(rays).tolist(), [40] * 3000)
        np.testing.assert_array_equal(expected.t, np.tile(np.arange(2, 42), 3000))
        for threads in (2, 5):
            found, same = scene.all_hits(origins, [0, 0, 1], threads=threads)
            np.testing.assert_array_equal(same, rays)
            for name in ("t", "u", "v", "Ng", "primID"):
                self.assertEqual(getattr(found, name).tobytes(), getattr(expected, name).tobytes(), name)

    def test_ranges_and_bounds(self):
        scene = cbvh.Scene([walls(20)])
        ray = [0.25, 0.5, -1], [0, 0, 1]
        for options, expected in (
            ({"tnear": 4.5}, np.arange(5, 21)),
            ({"tfar": 4.5}, np.arange(1, 5)),
            ({"tnear": 2.5, "tfar": 4.5}, [3, 4]),
            ({"max_hits": 3}, [1, 2, 3]),
            ({"max_hits": 0}, []),
            ({"max_hits": 100}, np.arange(1, 21)),
            ({"tnear": 50}, []),
        ):
            with self.subTest(options):
                hits, rays = scene.all_hits(*ray, **options)
                self.assertEqual(hits.t.tolist(), list(expected))
                self.assertEqual(rays.tolist(), [0] * len(expected))
        self.assertEqual(scene.all_hits(np.zeros((0, 3)), np.zeros((0, 3)))[1].shape, (0,))

    def test_both_triangles_at_an_edge_count(self):
        hits, _ = cbvh.Scene([walls(1)]).all_hits([[0, 0, -1], [0.5, 0.25, -1]], [0, 0, 1])
        self.assertEqual(hits.t.tolist(), [1, 1, 1])

    def test_errors_name_the_argument(self):
        scene = cbvh.Scene([walls(2)])
        ray = [0, 0, -1], [0, 0, 1]
        with self.assertRaisesRegex(ValueError, "max_hits: is -1"):
            scene.all_hits(*ray, max_hits=-1)
        with self.assertRaisesRegex(ValueError, r"origins has shape|origins.*\(2,\)"):
            scene.all_hits([0, 0], [0, 0, 1])
        with self.assertRaisesRegex(ValueError, "threads"):
            scene.all_hits(*ray, threads=-1)
        with self.assertRaisesRegex(cbvh.Error, "finding all hits: .*no triangles"):
            cbvh.build(bumpy_model(), "cleaf", 4).all_hits(*ray)


if __name__ == "__main__":
    unittest.main()
