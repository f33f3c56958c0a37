#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Cages from arrays match those from files, and errors name the invalid array."""

import inspect
import os
import tempfile
import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import sheet, sheet_arrays

CUBE = """\
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
f 6/1 5/2 8/3 7/4
f 2/1 6/2 7/3 3/4
f 5/1 1/2 4/3 8/4
f 4/1 3/2 7/3 8/4
f 5/1 6/2 2/3 1/4
t crease 2/1/0 0 1 2.5
t corner 1/1/0 6 3
t interpolateboundary 1/0/0 1
"""


class Cages(unittest.TestCase):
    def load(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "cube.obj")
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            return cbvh.Cage.load(path)

    def test_arrays_of_a_file_give_the_same_cage(self):
        a = self.load(CUBE)
        b = cbvh.Cage(
            a.vertices,
            a.indices,
            a.face_vertex_counts,
            uvs=a.uvs,
            uv_indices=a.uv_indices,
            crease_edges=a.crease_edges,
            crease_sharpness=a.crease_sharpness,
            corner_vertices=a.corner_vertices,
            corner_sharpness=a.corner_sharpness,
            holes=a.holes,
            boundary=a.boundary,
            name=a.name,
        )
        np.testing.assert_array_equal(a.crease_edges, [[0, 1]])
        np.testing.assert_array_equal(a.crease_sharpness, [2.5])
        np.testing.assert_array_equal(a.corner_vertices, [6])
        self.assertEqual(a.boundary, "edge_and_corner")
        for name in (
            "vertices",
            "indices",
            "face_vertex_counts",
            "uvs",
            "uv_indices",
            "crease_edges",
            "crease_sharpness",
            "corner_vertices",
            "corner_sharpness",
            "holes",
            "boundary",
            "name",
            "bounds",
        ):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), name)
        of_a, of_b = (cbvh.Model(cage).tessellate(3)[0] for cage in (a, b))
        np.testing.assert_array_equal(of_a, of_b)

    def test_sharpness_of_10_and_more_is_infinite(self):
        of_file = self.load(CUBE.replace(" 0 1 2.5", " 0 1 10").replace(" 6 3", " 6 10"))

        def surface(sharpness):
            cage = cbvh.Cage(
                of_file.vertices,
                of_file.indices,
                of_file.face_vertex_counts,
                crease_edges=[[0, 1]],
                crease_sharpness=sharpness,
                corner_vertices=[6],
                corner_sharpness=[sharpness],
            )
            return cbvh.Model(cage).tessellate(3)[0]

        hard = surface(np.inf)
        self.assertTrue((hard == of_file.vertices[6]).all(axis=1).any())
        for sharpness in (10, 11.5, 1e30):
            np.testing.assert_array_equal(surface(sharpness), hard)
        np.testing.assert_array_equal(cbvh.Model(of_file).tessellate(3)[0], hard)
        self.assertFalse(np.array_equal(surface(9.5), hard))

    def test_some_faces_may_have_no_texture_coordinates(self):
        none = 2**32 - 1
        a = self.load(CUBE.replace("f 6/1 5/2 8/3 7/4", "f 6 5 8 7"))
        b = cbvh.Cage(a.vertices, a.indices, a.face_vertex_counts, uvs=a.uvs, uv_indices=a.uv_indices)
        np.testing.assert_array_equal(a.uv_indices[:8], [0, 1, 2, 3, none, none, none, none])
        np.testing.assert_array_equal(a.uv_indices, b.uv_indices)
        cbvh.Model(b).tessellate(1)
        for cage, text in (
            (a, r"cube.obj:14: .*texture coordinates.*\bheight\b.* 1 .*\b6\b"),
            (b, r"texture coordinates.*\bheight\b.* 1 .*\b6\b"),
        ):
            with self.assertRaisesRegex(cbvh.Error, text):
                cbvh.Model(cage, np.zeros((4, 4)))
        with self.assertRaisesRegex(ValueError, "uv_indices: face 0 .*corners"):
            cbvh.Cage(a.vertices, a.indices, a.face_vertex_counts, uvs=a.uvs, uv_indices=np.roll(a.uv_indices, -6))
        without = cbvh.Cage(a.vertices, a.indices, a.face_vertex_counts, uvs=a.uvs, uv_indices=np.full(24, none))
        self.assertEqual(without.uv_indices.shape, (0,))

    def test_creases_shape_the_surface(self):
        edges = [[0, 1], [1, 2], [2, 3], [3, 0]]
        smooth, hard, soft = ({}, {"crease_edges": edges}, {"crease_edges": edges, "crease_sharpness": 0.5})
        cube = self.load(CUBE)
        cages = [
            cbvh.Cage(cube.vertices, cube.indices, cube.face_vertex_counts, **tags) for tags in (smooth, soft, hard)
        ]
        tops = [cbvh.build(cage, "grid", 4).bounds[1, 2] for cage in cages]
        self.assertLess(tops[0], tops[1])
        self.assertLess(tops[1], tops[2])

    def test_rows_of_faces_are_the_same_as_sizes(self):
        vertices, faces = sheet_arrays()
        a, b = cbvh.Cage(vertices, faces), cbvh.Cage(vertices, faces.ravel(), np.full(len(faces), 4))
        np.testing.assert_array_equal(a.indices, b.indices)
        np.testing.assert_array_equal(a.face_vertex_counts, b.face_vertex_counts)

    def test_all_number_types_are_accepted(self):
        vertices, faces = sheet_arrays()
        plain = cbvh.Cage(vertices, faces)
        for v, f in (
            (vertices.astype(np.float32), faces.astype(np.int8)),
            (np.asfortranarray(vertices), faces.tolist()),
            (np.repeat(vertices, 2, 0)[::2], np.asfortranarray(faces.astype(np.uint64))),
        ):
            cage = cbvh.Cage(v, f)
            np.testing.assert_array_equal(cage.vertices, plain.vertices)
            np.testing.assert_array_equal(cage.indices, plain.indices)

    def test_arrays_are_read_only_and_keep_their_data_alive(self):
        vertices = sheet().vertices  # the cage itself is released
        self.assertEqual(vertices.dtype, np.float32)
        np.testing.assert_array_equal(vertices, sheet_arrays()[0].astype(np.float32))
        with self.assertRaises(ValueError):
            vertices[0] = 1

    def test_invalid_arrays_are_reported_by_name(self):
        vertices, faces = sheet_arrays(2)
        flat = faces.ravel()
        nan = vertices.copy()
        nan[3, 1] = np.nan
        for error, text, arguments, options in (
            (ValueError, r"vertices: .*\(9, 2\).*\(n, 3\)", (vertices[:, :2], faces), {}),
            (ValueError, "vertices: row 3 .*finite", (nan, faces), {}),
            (TypeError, "vertices: .*complex128", (vertices + 1j, faces), {}),
            (TypeError, "vertices: .*<U1", ("x", faces), {}),
            (TypeError, "vertices: .*array", ([[1, 2], [3]], faces), {}),
            (TypeError, "indices: .*float64.*integers", (vertices, faces * 1.0), {}),
            (ValueError, "indices: .* -1.* 0 to 8", (vertices, faces - 1), {}),
            (ValueError, "indices: .* 9.* 0 to 8", (vertices, faces + 1), {}),
            (
                ValueError,
                "indices: .* 18446744073709551615.* 0 to 8",
                (vertices, np.full(faces.shape, 2**64 - 1, np.uint64)),
                {},
            ),
            (ValueError, r"indices: .*\(16,\)", (vertices, flat), {}),
            (ValueError, r"indices: .*\(0,\)", (vertices, []), {}),
            (ValueError, "indices: .*no faces", (vertices, [], []), {}),
            (ValueError, "face_vertex_counts: .* 15.* 16", (vertices, flat, [4, 4, 4, 3]), {}),
            (ValueError, "face_vertex_counts: face 1 .* 2 ", (vertices, flat, [4, 2, 4, 6]), {}),
            (ValueError, "uvs: .* 4 .*vertex, 9", (vertices, faces), {"uvs": np.zeros((4, 2))}),
            (ValueError, "^uv_indices: .*uvs", (vertices, faces), {"uv_indices": flat}),
            (
                ValueError,
                "uv_indices: .* 4 .*indices, 16",
                (vertices, faces),
                {"uvs": np.zeros((4, 2)), "uv_indices": [0, 1, 2, 3]},
            ),
            (ValueError, r"crease_edges: .*\(3,\).*\(n, 2\)", (vertices, faces), {"crease_edges": [0, 1, 2]}),
            (
                ValueError,
                "crease_sharpness: .* 2 .* 1",
                (vertices, faces),
                {"crease_edges": [[0, 1]], "crease_sharpness": [1, 2]},
            ),
            (
                ValueError,
                "corner_sharpness: .* -1",
                (vertices, faces),
                {"corner_vertices": [0], "corner_sharpness": -1},
            ),
            (ValueError, "holes: .* 4.* 0 to 3", (vertices, faces), {"holes": [4]}),
            (
                ValueError,
                "boundary: .*'round'.*'none'.*'edge_and_corner'.*'edge_only'",
                (vertices, faces),
                {"boundary": "round"},
            ),
            (cbvh.Error, "mine: face 1 .*vertex 1 ", (vertices, [[0, 0, 1, 2]]), {"name": "mine"}),
            (cbvh.Error, "mine: .* 16 .* 1024 ", (np.eye(17, 3), [range(17)]), {"name": "mine"}),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                cbvh.Cage(*arguments, **options)

    def test_unreadable_files_are_reported_by_name(self):
        with self.assertRaisesRegex(cbvh.Error, "/nowhere/body.obj"):
            cbvh.Cage.load("/nowhere/body.obj")
        with self.assertRaisesRegex(cbvh.Error, r"cube.obj:14: vertex index 55 .* 8 "):
            self.load(CUBE.replace("f 6/1 5/2", "f 6/1 55/2"))
        self.assertTrue(issubclass(cbvh.Error, ValueError))


class Documentation(unittest.TestCase):
    def test_all_public_names_have_docstrings(self):
        self.assertIn("cbvh.build", cbvh.__doc__)
        for name, member in vars(cbvh).items():
            if name.startswith("_"):
                continue
            self.assertTrue(inspect.getdoc(member), name)
            for part, attribute in vars(member).items() if inspect.isclass(member) else ():
                if not part.startswith("_"):
                    text = inspect.getdoc(attribute) or ""
                    lines = [line for line in text.splitlines() if line and not line.startswith(part + "(")]
                    self.assertTrue(lines, f"{name}.{part}")


if __name__ == "__main__":
    unittest.main()
