#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes are saved and loaded, and hit at the same places to the bit."""

import os
import tempfile
import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import bumpy_model, rays_from_above


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "sheet.cbvh")

    def test_what_is_loaded_is_what_was_saved(self):
        origins, directions = rays_from_above()
        for name in ("cvert", "cleaf", "cvoxel", "cgrid"):
            with self.subTest(name):
                scene = cbvh.build(bumpy_model(), name, 5)
                scene.save(self.path)
                hits = scene.intersect(origins, directions)
                loaded = cbvh.load(self.path)
                found = loaded.intersect(origins, directions)
                self.assertTrue(hits.hit.any())
                for field in ("t", "u", "v", "Ng", "primID", "geomID", "hit"):
                    self.assertEqual(getattr(hits, field).tobytes(), getattr(found, field).tobytes(), field)
                np.testing.assert_array_equal(loaded.occluded(origins, directions), hits.hit)
                self.assertGreater(loaded.trace_seconds(origins, directions), 0)
                for view in ("full", "close"):
                    seen = loaded.intersect(*cbvh.primary_rays(loaded.camera(view, (32, 24))))
                    self.assertTrue(seen.hit.any(), view)
                np.testing.assert_array_equal(loaded.bounds, scene.bounds)
                self.assertEqual(loaded.quads, scene.statistics()["quads"])
                self.assertIn("sheet.cbvh", repr(loaded))

    def test_damage_that_rays_meet_is_told_by_whoever_sends_them(self):
        origins, directions = rays_from_above()
        cbvh.build(bumpy_model(), "cvert", 6).save(self.path)
        with open(self.path, "r+b") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(size // 2)
            there = file.read(size // 4)
            file.seek(size // 2)
            file.write(bytes(byte ^ 255 for byte in there))
        calls = (
            lambda scene: scene.intersect(origins, directions),
            lambda scene: scene.occluded(origins, directions),
            lambda scene: scene.trace_seconds(origins, directions),
        )
        for call in calls:
            with self.assertRaisesRegex(cbvh.Error, "damaged"):
                call(cbvh.load(self.path))

    def test_what_cannot_be_saved_or_loaded_says_so(self):
        with self.assertRaisesRegex(ValueError, "compressed"):
            cbvh.build(bumpy_model(), "grid", 3).save(self.path)
        with self.assertRaisesRegex(cbvh.Error, "No such file"):
            cbvh.load(self.path)
        cbvh.build(bumpy_model(), "cvert", 3).save(self.path)
        with open(self.path, "r+b") as file:
            file.truncate(5000)
        with self.assertRaisesRegex(cbvh.Error, "truncated"):
            cbvh.load(self.path)
        with self.assertRaisesRegex(cbvh.Error, "cannot be written"):
            cbvh.build(bumpy_model(), "cvert", 3).save(os.path.join(self.path, "none"))


if __name__ == "__main__":
    unittest.main()
