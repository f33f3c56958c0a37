#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes are saved and loaded with bit-identical hits."""

import errno
import os
import pathlib
import pickle
import re
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import bumpy_model, rays_from_above, sheet


def errors_of_threads(call, count):
    """The messages of the errors, a line each, of calls by several threads."""
    errors = []

    def work():
        try:
            call()
        except cbvh.Error as error:
            errors.append(f"{error}\n")

    threads = [threading.Thread(target=work) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return "".join(errors)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "sheet.cbvh")

    def mappings(self):
        with open("/proc/self/maps", encoding="utf-8") as maps:
            return sum(line.rstrip().endswith(self.path) for line in maps)

    def test_objects_of_files_are_pickled_as_paths_and_mapped_once(self):
        ray = [[0.4, 0.4, 1]], [[0, 0, -1]]
        heights = np.random.default_rng(1).uniform(0, 0.5, (40, 40))
        for name, build, build_other, load in (
            (
                "scene",
                lambda: cbvh.build(bumpy_model(), "cvert", 5),
                lambda: cbvh.build(sheet(), "cvert", 4),
                cbvh.load,
            ),
            (
                "terrain",
                lambda: cbvh.terrain(heights, 0.1, (0, 2)),
                lambda: cbvh.terrain(heights + 0.25, 0.1, (0, 2)),
                cbvh.Terrain.load,
            ),
        ):
            with self.subTest(name):
                built = build()
                built.save(self.path)
                with self.assertRaisesRegex(TypeError, "in memory .*load"):
                    pickle.dumps(built)
                before = os.getcwd()
                try:
                    os.chdir(os.path.dirname(self.path))
                    loaded = load(os.path.basename(self.path))
                finally:
                    os.chdir(before)
                expected = loaded.intersect(*ray).t.tobytes()
                stored = pickle.dumps(loaded)
                self.assertLess(len(stored), 300)
                alone = self.mappings()
                with_copy = pickle.loads(stored)
                self.assertEqual(with_copy.intersect(*ray).t.tobytes(), expected)
                self.assertEqual(self.mappings(), alone)
                del loaded, built, with_copy
                self.assertEqual(self.mappings(), 0)
                copies = [pickle.loads(stored)]
                once = self.mappings()
                self.assertGreater(once, 0)
                copies += [pickle.loads(stored) for _ in range(3)] + [pickle.loads(pickle.dumps(copies[0]))]
                self.assertEqual(self.mappings(), once)
                for copy in copies:
                    self.assertEqual(copy.intersect(*ray).t.tobytes(), expected)
                code = (
                    "import pickle, sys; scene = pickle.load(sys.stdin.buffer); "
                    f"print(scene.intersect(*{ray}).t.tobytes().hex())"
                )
                other = subprocess.run([sys.executable, "-c", code], input=stored, stdout=subprocess.PIPE, check=True)
                self.assertEqual(other.stdout.decode().strip(), expected.hex())

                # A file that was replaced is another one; the old one is still mapped.
                build_other().save(self.path)
                changed = pickle.loads(stored).intersect(*ray)
                self.assertTrue(changed.hit.all())
                self.assertNotEqual(changed.t.tobytes(), expected)
                self.assertEqual(copies[0].intersect(*ray).t.tobytes(), expected)
                os.remove(self.path)
                with self.assertRaisesRegex(cbvh.Error, self.path):
                    pickle.loads(stored)

    def test_tiles_of_files_have_the_same_hits(self):
        origins, directions = rays_from_above()
        scene = cbvh.build(bumpy_model(), "cvert", 5)
        scene.save(self.path)
        mapped, tiled = (cbvh.load(self.path, representation=name) for name in ("cvert", "ctile"))
        a, b = (s.intersect(origins, directions) for s in (mapped, tiled))
        self.assertTrue(a.hit.any())
        np.testing.assert_array_equal(a.t, b.t)
        np.testing.assert_array_equal(a.primID, b.primID)
        self.assertGreater(tiled.statistics()["live_bytes"], mapped.statistics()["live_bytes"] + 3 * mapped.quads)
        with self.assertRaisesRegex(ValueError, "representation: .*'ctile' or 'cvert'"):
            cbvh.load(self.path, representation="grid")

    def test_loaded_scenes_match_saved_ones(self):
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

    def test_paths_are_str_or_path_like(self):
        class OfPath:
            def __init__(self, path):
                self.path = path

            def __fspath__(self):
                return self.path

        origins, directions = rays_from_above()
        scene = cbvh.build(bumpy_model(), "cvert", 3)
        hits = scene.intersect(origins, directions)
        for kind in (str, pathlib.Path, OfPath):
            with self.subTest(kind.__name__):
                scene.save(kind(self.path))
                found = cbvh.load(kind(self.path)).intersect(origins, directions)
                os.remove(self.path)
                self.assertEqual(hits.t.tobytes(), found.t.tobytes())
                with open(self.path, "w", encoding="ascii") as file:
                    file.write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
                self.assertEqual(len(cbvh.Cage.load(kind(self.path)).vertices), 4)
                os.remove(self.path)
        for call in (scene.save, cbvh.load, cbvh.Cage.load):
            with self.assertRaises(TypeError):
                call(1)

    def test_paths_may_contain_bytes_that_are_not_utf8(self):
        folder = os.path.dirname(self.path)
        cage_path, path = (os.path.join(folder, os.fsdecode(name)) for name in (b"quad\xff.obj", b"sheet\xff.cbvh"))
        with self.assertRaisesRegex(cbvh.Error, "sheet.*" + os.strerror(errno.ENOENT)):
            cbvh.load(path)
        with open(cage_path, "w", encoding="ascii") as file:
            file.write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        model = cbvh.Model(cbvh.Cage.load(cage_path))
        scene = cbvh.build(model, "cvert", 3)
        scene.save(path)
        for text in (model.name, model.cage.name, repr(model), repr(model.cage), repr(scene), repr(cbvh.load(path))):
            self.assertIn(b"\xff", os.fsencode(text))

    def test_damage_is_reported_to_the_caller_that_traces(self):
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
        expected = re.escape(self.path) + r": .*block.* \d"
        for call in calls:
            scene = cbvh.load(self.path)
            for _ in range(2):  # the library reports it once
                with self.assertRaisesRegex(cbvh.Error, expected):
                    call(scene)
        scene = cbvh.load(self.path)
        self.assertRegex(errors_of_threads(lambda: calls[0](scene), 4), rf"(.*{expected}.*\n){{4}}")

    def test_failed_saves_and_loads_report_the_reason(self):
        with self.assertRaisesRegex(ValueError, "compressed"):
            cbvh.build(bumpy_model(), "grid", 3).save(self.path)
        path = re.escape(self.path)
        with self.assertRaisesRegex(cbvh.Error, f"{path}: .*{os.strerror(errno.ENOENT)}"):
            cbvh.load(self.path)
        cbvh.build(bumpy_model(), "cvert", 3).save(self.path)
        with open(self.path, "r+b") as file:
            file.truncate(5000)
        with self.assertRaisesRegex(cbvh.Error, f"{path}: .* 5000 "):
            cbvh.load(self.path)
        with self.assertRaisesRegex(cbvh.Error, f"{path}/none: "):
            cbvh.build(bumpy_model(), "cvert", 3).save(os.path.join(self.path, "none"))

    def test_scene_does_not_replace_its_own_cage_or_map(self):
        cage_path, map_path = self.path + ".obj", self.path + ".pgm"
        cage = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
        heights = b"P5\n4 4\n255\n0123456789abcdef"
        with open(cage_path, "w", encoding="ascii") as file:
            file.write(cage)
        with open(map_path, "wb") as file:
            file.write(heights)
        model = cbvh.Model(cbvh.Cage.load(cage_path), map_path, amplitude=0.1)
        scene = cbvh.build(model, "cvert", 3)
        for path in (cage_path, map_path):
            with self.assertRaisesRegex(cbvh.Error, re.escape(path) + ": .*input"):
                scene.save(path)
        with open(cage_path, encoding="ascii") as file:
            self.assertEqual(file.read(), cage)
        with open(map_path, "rb") as file:
            self.assertEqual(file.read(), heights)
        scene.save(self.path)
        loaded = cbvh.load(self.path)
        scene.save(self.path)  # the mapped file remains the old one
        self.assertEqual(loaded.quads, scene.statistics()["quads"])


if __name__ == "__main__":
    unittest.main()
