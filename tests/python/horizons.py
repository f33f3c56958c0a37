#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Horizons, sky-view factors and viewsheds of terrains agree with brute force in double precision."""

import unittest

import numpy as np

import embree_cbvh as cbvh
from brute_force import closest_hits, grid_triangles
from terrains import NATIONAL, hills, points_of


def horizon_of_edges(eye, azimuth, triangles):
    """Elevation in degrees of the highest point of the triangles in a direction, where edges cross its plane."""
    along = np.array([np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))])
    a, b = (np.concatenate([np.roll(triangles, -k, 1)[:, i] for k in range(3)]) - eye for i in (0, 1))
    side_a, side_b = (p[:, 0] * along[1] - p[:, 1] * along[0] for p in (a, b))
    crosses = side_a * side_b < 0
    a, b, side_a, side_b = a[crosses], b[crosses], side_a[crosses], side_b[crosses]
    at = a + (side_a / (side_a - side_b))[:, None] * (b - a)
    distance = at[:, :2] @ along
    ahead = distance > 1e-9
    return np.degrees(np.arctan2(at[ahead, 2], distance[ahead]).max()) if ahead.any() else -90.0


class Horizons(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.heights = hills(40, 50)
        cls.points = points_of(cls.heights, 2.0, NATIONAL)
        cls.terrain = cbvh.terrain(cls.heights, 2.0, NATIONAL, max_error=0)
        cls.triangles = grid_triangles(cls.points)
        cls.eyes = cls.points[3:-3:6, 3:-3:8] + [0, 0, 1.5]
        cls.azimuths = np.arange(5.0, 360, 24.5)

    def test_horizons_are_those_of_all_edges(self):
        found = self.terrain.horizon(self.eyes, self.azimuths, accuracy=0.01)
        self.assertEqual(found.shape, (*self.eyes.shape[:2], len(self.azimuths)))
        expected = [[[horizon_of_edges(e, a, self.triangles) for a in self.azimuths] for e in row] for row in self.eyes]
        np.testing.assert_allclose(found, expected, atol=0.03)
        self.assertGreater(np.ptp(expected), 10)
        coarse = self.terrain.horizon(self.eyes, self.azimuths, accuracy=1)
        np.testing.assert_allclose(coarse, expected, atol=0.6)

    def test_sky_view_factors_are_means_over_horizons(self):
        azimuths = 360 * (np.arange(32) + 0.5) / 32
        horizon = self.terrain.horizon(self.eyes, azimuths)
        expected = (np.cos(np.radians(np.maximum(horizon, 0))) ** 2).mean(-1)
        found = self.terrain.sky_view_factor(self.eyes, 32)
        np.testing.assert_allclose(found, expected, atol=1e-5)
        self.assertTrue((found < 1).any())
        high = self.points[20, 25] + [0, 0, 1000]
        self.assertEqual(self.terrain.sky_view_factor(high), 1)
        outside = self.terrain.horizon(self.points[0, 0] + [-50, 50, 0], [315, 135], accuracy=0.001)
        self.assertAlmostEqual(float(outside[0]), -90, delta=0.001)
        self.assertGreater(outside[1], -30)

    def test_viewshed_is_what_nothing_hides(self):
        observer = self.points[20, 25] + [0, 0, 2]
        targets = (self.points[1:-1, 1:-1] + [0, 0, 0.5]).reshape(-1, 3)
        origin = self.points[0, 0]  # of smaller coordinates
        t, _ = closest_hits(
            np.broadcast_to(observer - origin, targets.shape), targets - observer, self.triangles - origin
        )
        seen = self.terrain.viewshed(observer, targets)
        self.assertEqual(seen.dtype, bool)
        self.assertLess((seen != (t > 1)).sum(), 4)  # rays that graze a ridge may be rounded to its other side
        self.assertTrue(0.1 < seen.mean() < 0.9, seen.mean())
        self.assertTrue(self.terrain.viewshed(observer, observer)[()])

    def test_invalid_input_is_reported_by_name(self):
        t, eye = self.terrain, [NATIONAL[0], NATIONAL[1], 400]
        for text, call in (
            (r"points: .*\(2,\).*\(\.\.\., 3\)", lambda: t.horizon([0, 0], [0])),
            ("points: point 0 is not finite", lambda: t.horizon([0, 0, np.nan], [0])),
            (r"azimuths: .*\(\).*\(n,\)", lambda: t.horizon(eye, 0)),
            ("azimuths: .*finite", lambda: t.horizon(eye, [np.inf])),
            ("accuracy: .*0", lambda: t.horizon(eye, [0], accuracy=0)),
            ("azimuths: is 0", lambda: t.sky_view_factor(eye, 0)),
            (r"observer: .*\(2,\)", lambda: t.viewshed([0, 0], eye)),
            ("threads: .*-1", lambda: t.viewshed(eye, eye, threads=-1)),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                call()


if __name__ == "__main__":
    unittest.main()
