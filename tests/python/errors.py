#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Errors match those that NumPy computes from the same hits."""

import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import sheet


class Errors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        model = cbvh.Model.generate("cube")
        cls.grid, cls.voxel = cbvh.build(model, "grid", 5), cbvh.build(model, "cvoxel", 5)
        cls.camera = cls.grid.camera("full", (160, 120))
        cls.rays = cbvh.primary_rays(cls.camera)
        cls.reference, cls.hits = cls.grid.intersect(*cls.rays), cls.voxel.intersect(*cls.rays)

    def test_pixel_errors_are_distances_over_pixel_sizes(self):
        errors = cbvh.pixel_errors(self.hits, self.reference, self.camera.pixel_size)
        both = self.hits.hit & self.reference.hit
        self.assertGreater(both.sum(), 100)
        np.testing.assert_array_equal(np.isnan(errors), ~both)
        t, at = self.hits.t[both], self.reference.t[both]
        np.testing.assert_allclose(errors[both], abs(t - at) / (self.camera.pixel_size * at), rtol=1e-4)

    def test_summary_matches_the_distances(self):
        pixels = cbvh.pixel_errors(self.hits, self.reference, self.camera.pixel_size)
        pixels = pixels[~np.isnan(pixels)].astype(float)
        errors = self.voxel.compare(self.hits, self.reference, self.camera.pixel_size)
        self.assertAlmostEqual(errors["rmse_pixels"], np.sqrt(np.mean(pixels**2)), places=4)
        self.assertAlmostEqual(errors["max_pixels"], pixels.max(), places=4)
        self.assertEqual(errors["both_hit"], len(pixels))
        self.assertEqual(errors["beyond_5_pixels"], (pixels > 5).sum())
        self.assertEqual(errors["false_hits"], (self.hits.hit & ~self.reference.hit).sum())
        self.assertEqual(errors["misses"], (self.reference.hit & ~self.hits.hit).sum())
        self.assertGreater(errors["false_hits"], 0)
        own = self.grid.compare(self.reference, self.reference, self.camera.pixel_size)
        self.assertEqual(own["max_pixels"], 0)

    def test_true_errors_decrease_with_the_level(self):
        model = self.grid.model
        coarse, fine = (cbvh.build(model, "grid", level) for level in (3, 5))
        medians = [
            scene.true_errors(scene.intersect(*self.rays), *self.rays, self.camera.pixel_size, count=500)
            for scene in (coarse, fine)
        ]
        self.assertEqual([m["hits"] for m in medians], [500, 500])
        self.assertLess(medians[1]["median_pixels"], medians[0]["median_pixels"])

    def test_mismatched_hits_are_reported_by_name(self):
        other = cbvh.build(sheet(), "grid", 3)
        pixel_size = self.camera.pixel_size
        wrong = other.intersect(*self.rays)
        few = self.grid.intersect(*(a[0] for a in self.rays))
        for text, call in (
            ("hits: .*scene.* 25 faces.* 6", lambda: self.grid.compare(wrong, wrong, pixel_size)),
            ("reference: .*scene.* 25 faces", lambda: self.grid.compare(self.hits, wrong, pixel_size)),
            ("reference: .* 160 rays.* 19200.*hits", lambda: self.grid.compare(self.hits, few, pixel_size)),
            ("reference: .* 160 rays", lambda: cbvh.pixel_errors(self.hits, few, pixel_size)),
            ("pixel_size: .* 0.* 0", lambda: cbvh.pixel_errors(self.hits, self.reference, 0)),
            (
                "hits: .* 160 rays.* 19200.*origins.*directions",
                lambda: self.grid.true_errors(few, *self.rays, pixel_size),
            ),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                call()


if __name__ == "__main__":
    unittest.main()
