#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Heights from arrays and files displace the surface correctly, and generated scenes do, too."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy as np

import embree_cbvh as cbvh
from sheets import rays_from_above, sheet, sheet_arrays

DIAGONAL = np.sqrt(2)  # diagonal of the sheet


def depths(model):
    origins, directions = rays_from_above()
    hits = cbvh.build(model, "grid", 5).intersect(origins, directions)
    assert hits.hit.all()
    return hits.t


class Heights(unittest.TestCase):
    def test_sheet_itself_is_flat(self):
        np.testing.assert_allclose(depths(cbvh.Model(sheet())), 1, atol=1e-6)

    def test_height_moves_the_sheet_along_its_normal(self):
        for height in (0.0, 0.5, 1.0):
            model = cbvh.Model(sheet(), np.full((4, 4), height), amplitude=0.2)
            np.testing.assert_allclose(depths(model), 1 - 0.2 * DIAGONAL * (height - 0.5), atol=1e-5)

    def test_columns_run_along_u_and_rows_down_from_v_of_1(self):
        x, y = np.moveaxis(rays_from_above()[0][..., :2], -1, 0)
        texels = (np.arange(256) + 0.5) / 256
        for heights, expected in ((np.tile(texels, (256, 1)), x), (np.tile(1 - texels[:, None], (1, 256)), y)):
            t = depths(cbvh.Model(sheet(), heights, amplitude=0.2))
            np.testing.assert_allclose(t, 1 - 0.2 * DIAGONAL * (expected - 0.5), atol=1e-3)

    def test_file_and_array_are_equivalent(self):
        bytes_ = np.random.default_rng(1).integers(0, 256, (32, 48), np.uint8)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "height.pgm"
            path.write_bytes(b"P5 48 32 255\n" + bytes_.tobytes())
            of_file = depths(cbvh.Model(sheet(), path, amplitude=0.1))
            of_text = depths(cbvh.Model(sheet(), str(path), amplitude=0.1))
        of_array = depths(cbvh.Model(sheet(), bytes_ / 255.0, amplitude=0.1))
        np.testing.assert_array_equal(of_file, of_text)
        self.assertGreater(np.ptp(of_file), 0.02)
        np.testing.assert_allclose(of_file, of_array, atol=0.1 * DIAGONAL / 255)

    def test_array_leaves_no_file(self):
        with tempfile.TemporaryDirectory() as folder:
            before = os.environ.get("TMPDIR")
            os.environ["TMPDIR"] = folder
            try:
                model = cbvh.Model(sheet(), np.zeros((8, 8)))
                self.assertEqual(len(os.listdir(folder)), 1)
                scene = cbvh.build(model, "cvert", 3)
                del model
                self.assertEqual(len(os.listdir(folder)), 1)  # the scene's model may still read it
                del scene
                self.assertEqual(os.listdir(folder), [])
            finally:
                if before is None:
                    del os.environ["TMPDIR"]
                else:
                    os.environ["TMPDIR"] = before

    def test_cage_without_uvs_gets_the_map_on_each_face_and_a_warning(self):
        cage = cbvh.Cage(*sheet_arrays(), name="plain")
        with self.assertWarnsRegex(UserWarning, r"^plain .*\bheight\b.*border"):
            cbvh.Model(cage, np.arange(16.0).reshape(4, 4))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            cbvh.Model(cage, np.ones((4, 4)))  # borders of the map match
            with self.assertRaises(UserWarning):
                cbvh.Model(cage, np.arange(16.0).reshape(4, 4))

    def test_invalid_arguments_are_reported_by_name(self):
        nan = np.zeros((4, 4))
        nan[2, 1] = np.inf
        for error, text, arguments, *options in (
            (ValueError, r"height: .*\(4,\).*\(rows, columns\)", (np.zeros(4),)),
            (ValueError, r"height: .*\(0, 4\)", (np.zeros((0, 4)),)),
            (ValueError, "height: row 2, column 1 .*finite", (nan,)),
            (ValueError, "height: .*masked", (np.ma.masked_equal(np.eye(4), 0),)),
            (ValueError, "wrap: .*mirror.*clamp.*repeat.*black", (np.eye(4),), {"wrap": "mirror"}),
            (TypeError, "height: .*complex128", (np.zeros((4, 4), complex),)),
            (ValueError, "^amplitude: .*height", (None, 1.0)),
            (ValueError, "amplitude: .*finite", (np.zeros((4, 4)), np.nan)),
            (cbvh.Error, r"^amplitude 1e\+38 .*large.*e\+16 ", (np.zeros((4, 4)), 1e38)),
            (cbvh.Error, r"^amplitude -1e\+18 .*large.*e\+16 ", (np.zeros((4, 4)), -1e18)),
            (cbvh.Error, "/nowhere/skin.exr", ("/nowhere/skin.exr",)),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                cbvh.Model(sheet(), *arguments, **(options[0] if options else {}))
        with self.assertRaisesRegex(cbvh.Error, r"^mid_level 1e\+38 .*large.*e\+19 "):
            cbvh.Model(sheet(), np.zeros((4, 4)), mid_level=1e38)

    def test_maps_continue_as_wrap_says(self):
        vertices, faces = sheet_arrays()
        cage = cbvh.Cage(vertices, faces, uvs=vertices[:, :2] + (1, 0), name="next to the image")
        heights = np.tile(np.linspace(0.2, 1, 64), (64, 1))
        x = rays_from_above()[0][..., 0]
        for wrap, expected in (("repeat", 0.2 + 0.8 * x), ("clamp", 1), ("black", 0)):
            t = depths(cbvh.Model(cage, heights, amplitude=0.2, wrap=wrap))
            np.testing.assert_allclose(t, 1 - 0.2 * DIAGONAL * (expected - 0.5), atol=4e-3)


class Seams(unittest.TestCase):
    """A cube, each of its faces in its own sixth of the map."""

    def setUp(self):
        corners = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
        faces = [(1, 3, 7, 5), (0, 4, 6, 2), (2, 6, 7, 3), (0, 1, 5, 4), (4, 5, 7, 6), (0, 2, 3, 1)]
        square = np.array([(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9)])
        uvs = np.concatenate([(square + (i % 3, i // 3)) / (3, 2) for i in range(6)])
        self.cage = cbvh.Cage(corners, faces, uvs=uvs, uv_indices=np.arange(24), name="box")

    def heights(self, of_charts, outside):
        """A map of 96 x 96 texels; texels whose center is outside of all charts have the height `outside`."""
        row, column = (np.mgrid[0:96, 0:96] + 0.5) / 96
        s, t = 3 * column, 2 * (1 - row)
        inside = (np.abs(s % 1 - 0.5) <= 0.4) & (np.abs(t % 1 - 0.5) <= 0.4)
        return np.where(inside, np.asarray(of_charts)[(s // 1 + 3 * (t // 1)).astype(int)], outside)

    def test_heights_outside_of_charts_do_not_matter(self):
        expected = cbvh.Model(self.cage, np.full((4, 4), 0.75), amplitude=0.1).tessellate(4)[0]
        for outside in (0, 10):
            model = cbvh.Model(self.cage, self.heights([0.75] * 6, outside), amplitude=0.1)
            np.testing.assert_allclose(model.tessellate(4)[0], expected, atol=1e-5)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                statistics = cbvh.build(model, "cvert", 4).statistics()
            self.assertLess(statistics["seam_gap"], 1e-5)

    def test_charts_that_disagree_cause_a_warning(self):
        model = cbvh.Model(self.cage, self.heights([0.25, 0.75, 0.5, 0.5, 0.5, 0.5], 0), amplitude=0.1)
        with self.assertWarnsRegex(UserWarning, r"^box: .* quads at face \d.*seams"):
            scene = cbvh.build(model, "cvert", 5)
        diagonal = 2 * np.sqrt(3)
        self.assertAlmostEqual(scene.statistics()["seam_gap"], 0.25 * 0.1 * diagonal, 5)
        self.assertGreater(scene.statistics()["seam_gap_quads"], 0.25 * 0.1 * diagonal / (2 / 32) - 1e-3)


class Scenes(unittest.TestCase):
    def test_scenes_are_created_by_name(self):
        self.assertIn("trex", cbvh.scene_names())
        cube = cbvh.Model.generate("cube")
        self.assertEqual(cube.name, "cube")
        self.assertTrue(cube.is_displaced)
        self.assertEqual(len(cube.cage.face_vertex_counts), 6)
        flat, spiky = (cbvh.build(cbvh.Model.generate("cube", a), "grid", 4).bounds for a in (0.0, 0.2))
        self.assertLess(flat[1, 0], spiky[1, 0])

    def test_invalid_options_are_reported_by_their_python_names(self):
        for text, name, options in (
            (r"(?<!-)\bscene 'cow'.*cube", "cow", {}),
            ("^rough .*scene trex", "cube", {"rough": True}),
            ("^count .*scene herd", "cube", {"count": 3}),
            (r"(?<!-)\bmapping 'sphere'.*faces.*atlas", "trex", {"mapping": "sphere"}),
        ):
            with self.subTest(text), self.assertRaisesRegex(cbvh.Error, text):
                cbvh.Model.generate(name, **options)

    def test_stopped_map_generation_leaves_no_file(self):
        def enough(phase, _):
            self.assertEqual(phase, "trex: skin")
            raise LookupError

        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(LookupError):
                cbvh.Model.generate("trex", map_folder=folder, progress=enough)
            self.assertEqual(os.listdir(folder), [])
            code = (
                "import embree_cbvh as c\ndef stop(*_): raise LookupError\n"
                "try: c.Model.generate('trex', progress=stop)\nexcept LookupError: pass"
            )
            subprocess.run(
                [sys.executable, "-B", "-c", code], cwd="/", env={**os.environ, "XDG_CACHE_HOME": folder}, check=True
            )
            self.assertEqual(os.listdir(folder), ["embree-cbvh"])
        with self.assertRaisesRegex(cbvh.Error, "/dev/null"):
            cbvh.Model.generate("trex", map_folder="/dev/null/maps")


class Meshes(unittest.TestCase):
    def test_mesh_matches_grid(self):
        model = cbvh.Model.generate("cube")
        vertices, quads = model.tessellate(4)
        self.assertEqual(quads.shape, (model.num_quads(4), 4))
        self.assertEqual(vertices.shape, (6 * 17 * 17, 3))
        bounds = cbvh.build(model, "grid", 4).bounds
        np.testing.assert_allclose([vertices.min(0), vertices.max(0)], bounds, atol=1e-6)
        # Counterclockwise seen from the front: outward at the first corner of nearly every quad of a bumpy cube.
        a, b, d = (vertices[quads[:, i]] for i in (0, 1, 3))
        outward = np.einsum("ij,ij->i", np.cross(b - a, d - a), a) > 0
        self.assertGreater(outward.mean(), 0.9)

    def test_polygons_consist_of_a_patch_per_corner(self):
        cage = cbvh.Cage([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], [0, 1, 2, 3, 1, 4, 2], [4, 3])
        model = cbvh.Model(cage)
        self.assertEqual(model.num_quads(3), 64 + 3 * 16)
        vertices, quads = model.tessellate(3)
        self.assertEqual(len(quads), 64 + 3 * 16)
        self.assertEqual(len(vertices), 81 + 3 * 25)
        self.assertEqual(quads.max(), len(vertices) - 1)
        with self.assertRaisesRegex(cbvh.Error, "^level 0: face 1 .*quad"):
            model.tessellate(0)
        with self.assertRaisesRegex(cbvh.Error, "^level 9 .* 0 to 8"):
            model.tessellate(9)


if __name__ == "__main__":
    unittest.main()
