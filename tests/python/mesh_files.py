#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of files of all formats are read with their polygons and doubles, and traced."""

import json
import os
import pathlib
import struct
import tempfile
import unittest
import warnings

import numpy as np

import embree_cbvh as cbvh

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
L_SHAPE = [(0, 0, 0), (3, 0, 0), (3, 1, 0), (1, 1, 0), (1, 3, 0), (0, 3, 0)]


def obj(vertices, faces):
    lines = ["v " + " ".join(repr(x) for x in v) for v in vertices]
    return "\n".join(lines + ["f " + " ".join(str(i + 1) for i in face) for face in faces]).encode() + b"\n"


def ply(vertices, faces, kind=">d"):
    name = {">d": "double", ">f": "float"}[kind]
    header = f"ply\nformat binary_big_endian 1.0\nelement vertex {len(vertices)}\n"
    header += "".join(f"property {name} {axis}\n" for axis in "xyz")
    header += f"element face {len(faces)}\nproperty list uint8 uint16 vertex_indices\nend_header\n"
    data = [struct.pack(">B", len(face)) + struct.pack(f">{len(face)}H", *face) for face in faces]
    return header.encode() + np.array(vertices, kind).tobytes() + b"".join(data)


def stl(triangles):
    rows = [struct.pack("<12fH", 0, 0, 1, *np.ravel(corners), 0) for corners in triangles]
    return b"solid by hand".ljust(80) + struct.pack("<I", len(rows)) + b"".join(rows)


def gltf(vertices, triangles):
    data = np.array(vertices, "<f4").tobytes(), np.array(triangles, "<u4").tobytes()
    views = [{"buffer": 0, "byteOffset": sum(map(len, data[:i])), "byteLength": len(data[i])} for i in range(2)]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"},
    ]
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": sum(map(len, data))}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "scale": [-1, 1, 1]}],
        "scenes": [{"nodes": [0]}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(b"".join(data)), b"BIN\0")
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks) + len(b"".join(data))) + chunks + b"".join(data)


class MeshFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, data):
        path = self.folder / name
        path.write_bytes(data)
        return path

    def test_all_formats_are_read_and_hit(self):
        triangles = [(0, 1, 2), (0, 2, 3)]
        files = {
            "a.obj": obj(SQUARE, triangles),
            "a.ply": ply(SQUARE, triangles, ">f"),
            "a.stl": stl(np.array(SQUARE)[np.array(triangles)]),
            "a.glb": gltf(SQUARE, triangles),
        }
        for name, data in files.items():
            with self.subTest(name):
                path = self.write(name, data)
                mesh = cbvh.read_mesh(path)
                self.assertEqual(mesh["vertices"].dtype, np.float64)
                self.assertEqual(mesh["vertices"].shape, (4, 3))
                self.assertEqual(mesh["indices"].shape, (2, 3))
                self.assertEqual(mesh["faces"].tolist(), [0, 1])
                scene = cbvh.Scene([cbvh.Mesh.load(os.fspath(path), max_error=0)])
                side = -1 if name == "a.glb" else 1
                hits = scene.intersect([0.25 * side, 0.5, 3], [0, 0, -1])
                self.assertEqual((float(hits.t), int(hits.primID)), (3, 1))
                self.assertGreater(float(hits.Ng[2]), 0, "the front is up, also of a mirrored node")

    def test_polygons_become_triangles_that_know_their_face(self):
        mesh = cbvh.read_mesh(self.write("l.obj", obj(L_SHAPE, [range(6), (0, 1, 3, 5)])))
        self.assertEqual(mesh["indices"].shape, (5, 4))
        self.assertEqual(mesh["faces"].tolist(), [0, 0, 0, 0, 1])
        scene = cbvh.Scene([cbvh.Mesh.load(self.write("m.ply", ply(L_SHAPE, [range(6)])), max_error=0)])
        y, x = np.mgrid[0.1:3:0.2, 0.1:3:0.2]
        hits = scene.intersect(np.stack([x, y, 1 + 0 * x], -1), [0, 0, -1])
        np.testing.assert_array_equal(hits.hit, (x < 1) | (y < 1))

    def test_doubles_stay_and_rounding_warns(self):
        far = [(500000.123456 + x, 5400000.654321 + y, z) for x, y, z in SQUARE]
        for name, data in (("a.obj", obj(far, [range(4)])), ("a.ply", ply(far, [range(4)]))):
            path = self.write(name, data)
            np.testing.assert_array_equal(cbvh.read_mesh(path)["vertices"], far)
            with self.assertWarnsRegex(UserWarning, "32 bits.*origin"):
                cbvh.Mesh.load(path)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            cbvh.Mesh.load(self.write("near.ply", ply(SQUARE, [range(4)])))

    def test_damaged_files_raise_errors_with_their_name(self):
        data = ply(SQUARE, [range(4)])
        for name, damaged, words in (
            ("short.ply", data[:-1], "face 0"),
            ("long.ply", data + b"a", "follows"),
            ("nan.ply", ply([(0, 0, float("nan"))] * 3, [range(3)]), "vertex 0.*nan"),
            ("range.ply", ply(SQUARE, [(0, 1, 4)]), "index 4"),
            ("short.stl", stl([SQUARE[:3]])[:-1], "bytes"),
            ("short.glb", gltf(SQUARE, [(0, 1, 2)])[:-1], "ends"),
        ):
            with self.subTest(name), self.assertRaisesRegex(cbvh.Error, name + ".*" + words):
                cbvh.read_mesh(self.write(name, damaged))
        with self.assertRaisesRegex(cbvh.Error, "missing.ply"):
            cbvh.Mesh.load(self.folder / "missing.ply")
        with self.assertRaises(TypeError):
            cbvh.read_mesh(3)


if __name__ == "__main__":
    unittest.main()
