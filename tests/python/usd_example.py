#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""The example for USD converts meshes. A stand-in has the few calls of USD's Python module.

usd_example.py EXAMPLE
"""

import importlib
import os
import sys
import tempfile
import types
import unittest
import warnings
import weakref

import numpy as np

import embree_cbvh as cbvh

EXAMPLE = sys.argv.pop(1)


class Value:
    def __init__(self, value):
        self.value = value

    def Get(self, time):
        assert time == "earliest", time
        return self.value


class Primvar(Value):
    def __init__(self, value=None, interpolation="faceVarying", indices=None):
        super().__init__(value)
        self.interpolation, self.indices = interpolation, indices

    def HasValue(self):
        return self.value is not None

    def GetInterpolation(self):
        return self.interpolation

    def IsIndexed(self):
        return self.indices is not None

    def GetIndices(self, time):
        assert time == "earliest", time
        return self.indices


class Mesh:
    """Two squares and a triangle in a row, from x = 0 to 3."""

    def __init__(self, **changes):
        self.values = {
            "Points": [(x, y, 0) for y in (0, 1) for x in (0, 1, 2)] + [(3, 0, 0)],
            "FaceVertexCounts": [4, 4, 3],
            "FaceVertexIndices": [0, 1, 4, 3, 1, 2, 5, 4, 2, 6, 5],
            "SubdivisionScheme": "catmullClark",
            "TriangleSubdivisionRule": "catmullClark",
            "InterpolateBoundary": "edgeAndCorner",
            "FaceVaryingLinearInterpolation": "all",
            "Orientation": "rightHanded",
            **changes,
        }
        self.primvar = self.values.pop("st", Primvar())
        self.matrix = self.values.pop("matrix", np.eye(4))
        self.visibility = self.values.pop("visibility", "inherited")
        self.purpose = self.values.pop("purpose", "default")
        self.kind = self.values.pop("kind", usd_geom.Mesh)
        self.children = self.values.pop("children", [])

    def __getattr__(self, name):
        if not (name.startswith("Get") and name.endswith("Attr")):
            raise AttributeError(name)
        return lambda: Value(self.values.get(name[3:-4]))

    def GetPath(self):
        return "/world/mesh"

    def ComputeLocalToWorldTransform(self, time):
        assert time == "earliest", time
        return self.matrix

    def IsA(self, kind):
        return kind is self.kind

    def ComputeVisibility(self, time):
        assert time == "earliest", time
        return self.visibility

    def ComputePurpose(self):
        return self.purpose


class PrimvarsAPI:
    def __init__(self, mesh):
        self.mesh = mesh

    def GetPrimvar(self, name):
        return self.mesh.primvar if name == "st" else Primvar()


class Stage:
    def __init__(self, prims):
        self.prims = prims


class PrimRange:
    """Prims in depth-first order. Like USD's, it does not keep the stage alive."""

    def __init__(self, stage):
        self.stage, self.pending, self.children = weakref.ref(stage), stage.prims[::-1], []

    def __iter__(self):
        return self

    def __next__(self):
        assert self.stage(), "the stage is gone"
        self.pending += self.children[::-1]
        if not self.pending:
            raise StopIteration
        prim = self.pending.pop()
        self.children = prim.children
        return prim

    def PruneChildren(self):
        self.children = []

    @staticmethod
    def Stage(stage, predicate):
        assert predicate == "instances, too"
        return PrimRange(stage)


PRIMS = []
usd_geom = types.SimpleNamespace(
    PrimvarsAPI=PrimvarsAPI, Mesh=lambda prim: prim, Imageable=lambda prim: prim, PointInstancer=object()
)
usd = types.SimpleNamespace(
    TimeCode=types.SimpleNamespace(EarliestTime=lambda: "earliest"),
    Stage=types.SimpleNamespace(Open=lambda path: Stage(PRIMS)),
    PrimRange=PrimRange,
    TraverseInstanceProxies=lambda: "instances, too",
)
sys.modules["pxr"] = types.SimpleNamespace(Usd=usd, UsdGeom=usd_geom)
sys.path.insert(0, os.path.dirname(EXAMPLE))
example = importlib.import_module(os.path.splitext(os.path.basename(EXAMPLE))[0])


def convert(**changes):
    return example.cage_of(Mesh(**changes), "earliest")


class Usd(unittest.TestCase):
    def test_topology_and_rules(self):
        cage = convert(HoleIndices=[1], CornerIndices=[3, 0], CornerSharpnesses=[10.0, 2.5])
        self.assertEqual(cage.face_vertex_counts.tolist(), [4, 4, 3])
        self.assertEqual(cage.indices.tolist(), Mesh().values["FaceVertexIndices"])
        self.assertEqual(cage.vertices.tolist(), [list(p) for p in Mesh().values["Points"]])
        self.assertEqual(cage.holes.tolist(), [1])
        self.assertEqual(cage.corner_vertices.tolist(), [3, 0])
        self.assertEqual(cage.corner_sharpness.tolist(), [np.inf, 2.5])
        self.assertEqual((len(cage.crease_edges), len(cage.uvs), cage.name), (0, 0, "/world/mesh"))
        for usd_rule, rule in (("none", "none"), ("edgeOnly", "edge_only"), ("edgeAndCorner", "edge_and_corner")):
            self.assertEqual(convert(InterpolateBoundary=usd_rule).boundary, rule)

    def test_creases_with_one_sharpness_or_one_per_edge(self):
        creases = {"CreaseIndices": [0, 1, 2, 1, 4], "CreaseLengths": [3, 2]}
        for sharpness, expected in (([3.0, 10.0], [3, 3, np.inf]), ([1.0, 2.0, 3.0], [1, 2, 3])):
            cage = convert(CreaseSharpnesses=sharpness, **creases)
            self.assertEqual(cage.crease_edges.tolist(), [[0, 1], [1, 2], [1, 4]])
            self.assertEqual(cage.crease_sharpness.tolist(), expected)

    def test_faces_are_counterclockwise_from_the_front(self):
        mirrored = np.diag([1, 1, -1, 1])
        for orientation, matrix, z in (
            ("rightHanded", np.eye(4), 1),
            ("leftHanded", np.eye(4), -1),
            ("rightHanded", mirrored, -1),  # the front is mirrored, too
            ("leftHanded", mirrored, 1),
        ):
            uvs = Primvar([(x / 3, y) for x, y, _ in Mesh().values["Points"]], "varying")
            cage = convert(Orientation=orientation, matrix=matrix, st=uvs)
            scene = cbvh.Scene([cbvh.Subdivision(cage, 3)])
            hits = scene.intersect([[0.5, 0.5, 1], [1.5, 0.5, 1]], [0, 0, -1])
            self.assertTrue(hits.hit.all())
            self.assertTrue((np.sign(hits.Ng[:, 2]) == z).all(), (orientation, z))
            np.testing.assert_allclose(cage.vertices[cage.indices, 0], 3 * cage.uvs[cage.uv_indices, 0], atol=1e-6)

    def test_meshes_are_in_world_space(self):
        matrix = np.eye(4)
        matrix[:3, :3] = [[0, 2, 0], [-2, 0, 0], [0, 0, 2]]  # of row vectors: x becomes 2 y
        matrix[3, :3] = [10, 20, 30]
        vertices = convert(matrix=matrix).vertices
        self.assertEqual(vertices[6].tolist(), [10, 26, 30])
        self.assertEqual(vertices[3].tolist(), [8, 20, 30])

    def test_texture_coordinates_of_all_kinds(self):
        points = np.array(Mesh().values["Points"], float)[:, :2] / 3
        corners = np.array(Mesh().values["FaceVertexIndices"])
        for primvar in (
            Primvar(points, "varying"),
            Primvar(points, "vertex"),
            Primvar(points[corners], "faceVarying"),
            Primvar(points, "faceVarying", corners),
            Primvar(points[::-1], "vertex", np.arange(6, -1, -1)),
        ):
            with warnings.catch_warnings(record=True) as found:
                warnings.simplefilter("always")
                cage = convert(st=primvar)
            self.assertEqual(len(found), primvar.interpolation == "vertex")
            np.testing.assert_array_equal(cage.uvs[cage.uv_indices], np.float32(points[corners]))
        with self.assertWarnsRegex(UserWarning, "/world/mesh: st is smooth in USD"):
            convert(st=Primvar(points[corners]), FaceVaryingLinearInterpolation="cornersPlus1")

    def test_errors_name_the_mesh(self):
        for text, changes in (
            ("subdivisionScheme is loop", {"SubdivisionScheme": "loop"}),
            ("subdivisionScheme is none", {"SubdivisionScheme": "none"}),
            ("triangleSubdivisionRule is smooth", {"TriangleSubdivisionRule": "smooth"}),
            ("faceVertexCounts add up to 8 of 11", {"FaceVertexCounts": [4, 4]}),
            ("creaseLengths do not fit 3", {"CreaseIndices": [0, 1, 2], "CreaseLengths": [2]}),
            ("2 creaseSharpnesses", {"CreaseIndices": [0, 1], "CreaseLengths": [2], "CreaseSharpnesses": [1, 2]}),
            ("st is constant", {"st": Primvar([(0, 0)], "constant")}),
            ("st has 3 indices", {"st": Primvar([(0, 0)], "faceVarying", [0, 0, 0])}),
            ("uv_indices", {"st": Primvar([(0, 0)], "faceVarying")}),
            ("holes", {"HoleIndices": [9]}),
            ("indices", {"FaceVertexIndices": [0, 1, 4, 3, 1, 2, 5, 4, 2, 7, 5]}),
        ):
            with self.assertRaisesRegex(ValueError, "/world/mesh: " + text):
                convert(**changes)

    def test_a_stage_is_saved(self):
        PRIMS[:] = [
            Mesh(),
            Mesh(visibility="invisible"),
            Mesh(SubdivisionScheme="loop"),
            Mesh(purpose="guide"),
            Mesh(purpose="proxy"),
            Mesh(kind=usd_geom.PointInstancer, children=[Mesh()]),
            Mesh(kind="Xform", children=[Mesh(purpose="render", matrix=np.diag([2, 2, 2, 1]))]),
        ]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "stage.cbvh")
            sys.argv[1:] = ["stage.usd", path, "--level", "3"]
            with warnings.catch_warnings(record=True) as found:
                warnings.simplefilter("always")
                example.main()
            self.assertEqual(len(found), 2)
            self.assertIn("left out: /world/mesh: subdivisionScheme is loop", str(found[0].message))
            self.assertIn("left out: instances of /world/mesh", str(found[1].message))
            self.assertEqual(cbvh.load(path).geometries, 2)
        del sys.argv[1:]


if __name__ == "__main__":
    unittest.main()
