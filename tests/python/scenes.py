#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes in every representation are hit at the right positions, with rays in arrays of any kind."""

import tempfile
import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import REPRESENTATIONS, bumpy_model, rays_from_above, sheet, sheet_arrays
from triangle_distances import distances_to_triangles

MISS = 2**32 - 1


class Hits(unittest.TestCase):
    def test_flat_sheet_is_hit_at_its_position(self):
        origins, directions = rays_from_above()
        column, row = (np.floor(origins[..., axis] * 5).astype(int) for axis in (0, 1))
        for name in REPRESENTATIONS:
            with self.subTest(name):
                hits = cbvh.build(sheet(), name, 4).intersect(origins, directions)
                self.assertTrue(hits.hit.all())
                self.assertEqual(hits.t.dtype, np.float32)
                np.testing.assert_allclose(hits.t, 1, atol=1e-5)
                np.testing.assert_array_equal(hits.primID, 5 * row + column)
                np.testing.assert_array_equal(hits.geomID, 0)
                np.testing.assert_allclose(hits.u, origins[..., 0] * 5 - column, atol=2e-2)
                np.testing.assert_allclose(hits.v, origins[..., 1] * 5 - row, atol=2e-2)
                normals = hits.Ng / np.linalg.norm(hits.Ng, axis=-1, keepdims=True)
                np.testing.assert_allclose(normals, np.broadcast_to([0, 0, 1], normals.shape), atol=1e-3)

    def test_misses_are_marked(self):
        hits = cbvh.build(sheet(), "cvert", 4).intersect([[0.5, 0.5, 1], [5, 5, 1]], [0, 0, -1])
        self.assertEqual(hits.hit.tolist(), [True, False])
        self.assertEqual(hits.t.tolist()[1], np.inf)
        self.assertEqual(hits.primID.tolist(), [12, MISS])
        self.assertEqual(hits.geomID.tolist(), [0, MISS])
        self.assertEqual(hits.Ng[1].tolist(), [0, 0, 0])

    def test_hits_are_read_only_and_outlive_the_scene(self):
        t = cbvh.build(sheet(), "cvert", 3).intersect(*rays_from_above()).t
        np.testing.assert_allclose(t, 1, atol=1e-5)
        with self.assertRaises(ValueError):
            t[0, 0] = 0

    def test_nearer_hits(self):
        scene = cbvh.build(sheet(), "grid", 3)
        near = scene.intersect([[0.5, 0.5, 1], [0.5, 0.5, 3], [5, 5, 1]], [0, 0, -1])
        far = scene.intersect([[0.5, 0.5, 2], [0.5, 0.5, 2], [0.5, 0.5, 4]], [0, 0, -1])
        np.testing.assert_allclose(cbvh.nearer_hits(near, far).t, [1, 2, 4], atol=1e-5)
        with self.assertRaisesRegex(ValueError, "b: .* 1 .* 3"):
            cbvh.nearer_hits(near, scene.intersect([0.5, 0.5, 2], [0, 0, -1]))


class ClosestPoints(unittest.TestCase):
    def test_equal_those_of_the_stored_triangles(self):
        scene = cbvh.build(bumpy_model(), "ctile", 4)
        mesh = scene.stored_mesh()
        corners = mesh["vertices"][mesh["quads"][:, [[0, 1, 3], [1, 2, 3]]].reshape(-1, 3)].astype(np.float64)
        primitives = np.repeat(mesh["primID"], 2)
        rng = np.random.default_rng(5)
        points = rng.uniform(-0.5, 1.5, (20, 2, 3))
        positions, hits = scene.closest_points(points)
        self.assertEqual(positions.shape, (20, 2, 3))
        self.assertEqual(hits.shape, (20, 2))
        for index in np.ndindex(20, 2):
            distances = distances_to_triangles(points[index].astype(np.float32), corners)
            self.assertAlmostEqual(hits.t[index], distances.min(), delta=1e-6)
            self.assertAlmostEqual(hits.t[index], np.linalg.norm(positions[index] - points[index]), delta=1e-5)
            self.assertAlmostEqual(distances[primitives == hits.primID[index]].min(), distances.min(), delta=1e-9)

    def test_radius_time_and_files(self):
        scene = cbvh.build(rising_model(), "cvert", 4)
        positions, hits = scene.closest_points([0.5, 0.5, 1], [2, 0.7, 0.4], time=[0, 0.6, 1])
        self.assertEqual(hits.hit.tolist(), [True, True, False])
        np.testing.assert_allclose(hits.t[:2], [1, 0.7], atol=1e-5)
        np.testing.assert_allclose(positions, [[0.5, 0.5, 0], [0.5, 0.5, 0.3], [np.nan] * 3], atol=1e-5)
        with tempfile.TemporaryDirectory() as folder:
            scene.save(folder + "/sheet")
            again, same = cbvh.load(folder + "/sheet").closest_points([0.5, 0.5, 1], 2)
        np.testing.assert_array_equal(again, positions[0])
        self.assertEqual(same.t, hits.t[0])

    def test_errors(self):
        scene = cbvh.build(sheet(), "ctile", 3)
        with self.assertRaisesRegex(ValueError, "radius"):
            scene.closest_points([0, 0, 0], -1)
        with self.assertRaisesRegex(ValueError, "points"):
            scene.closest_points([0, 0])
        with self.assertRaisesRegex(ValueError, "points: .*coordinate nan"):
            scene.closest_points([0, np.nan, 0])
        with self.assertRaisesRegex(cbvh.Error, "cTILE or cVERT"):
            cbvh.build(sheet(), "grid", 3).closest_points([0, 0, 0])


def cube_arrays(lower, upper, n):
    """Vertices and quads of the surface of a cube, n x n per side. Sides share vertices."""
    grid = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3, indexing="ij"), -1)
    on_surface = ((grid == 0) | (grid == n)).any(-1)
    number = np.cumsum(on_surface.ravel()).reshape(on_surface.shape) - 1
    quads = []
    for axis in range(3):
        for plane in (0, n):
            side = np.take(number, plane, axis)
            corners = [side[:-1, :-1], side[1:, :-1], side[1:, 1:], side[:-1, 1:]]
            outward = (plane == n) != (axis == 1)
            quads.append(np.stack(corners[:: 1 if outward else -1], -1).reshape(-1, 4))
    return lower + (upper - lower) * grid[on_surface] / n, np.concatenate(quads)


def cube_mesh(lower=0.0, upper=1.0, **options):
    return cbvh.Mesh(*cube_arrays(lower, upper, 8), **options)


def distance_from_cube(points, lower=0.0, upper=1.0):
    """Positive inside."""
    outside = np.maximum(np.maximum(lower - points, points - upper), 0)
    inside = np.minimum(points - lower, upper - points).min(-1)
    return np.where(inside > 0, inside, -np.linalg.norm(outside, axis=-1))


class Distances(unittest.TestCase):
    def check(self, scene, points, expected, tolerance):
        """expected: positive inside."""
        np.testing.assert_allclose(scene.distance(points), np.abs(expected), atol=tolerance)
        clear = np.abs(expected) > tolerance
        self.assertGreater(clear.mean(), 0.9)
        np.testing.assert_array_equal(scene.contains(points)[clear], expected[clear] > 0)
        np.testing.assert_allclose(scene.signed_distance(points)[clear], expected[clear], atol=tolerance)
        np.testing.assert_array_equal(scene.signed_distance(points, threads=1), scene.signed_distance(points))

    def test_cube(self):
        points = np.random.default_rng(3).uniform(-0.5, 1.5, (40, 50, 3))
        inside = np.stack(np.meshgrid(*[np.arange(1, 16) / 16] * 3), -1)  # vertices and edges ahead along the axes
        for representation in ("ctile", "cvert"):
            scene = cbvh.Scene([cube_mesh(max_error=0)], representation)
            self.check(scene, points, distance_from_cube(points), 1e-6)
            self.check(scene, inside, distance_from_cube(inside), 1e-6)

    def test_sphere(self):
        radius = 0.5
        vertices, quads = cube_arrays(-1.0, 1.0, 64)
        vertices *= radius / np.linalg.norm(vertices, axis=1, keepdims=True)
        scene = cbvh.Scene([cbvh.Mesh(vertices, quads, max_error=0)])
        points = np.random.default_rng(4).uniform(-1, 1, (3000, 3))
        self.check(scene, points, radius - np.linalg.norm(points, axis=-1), 2e-3)

    def test_nested_bodies(self):
        """A hollow cube next to another one: a shell is inside, its cavity and the rest of space are outside."""
        scene = cbvh.Scene([cube_mesh(), cube_mesh(0.25, 0.75), cube_mesh(2, 3)])
        points = np.random.default_rng(5).uniform(-0.5, 3.5, (4000, 3))
        signed = [distance_from_cube(points, *box) for box in ((0, 1), (0.25, 0.75), (2, 3))]
        expected = (np.array(signed) > 0).sum(0) % 2 * 2 - 1
        self.check(scene, points, expected * np.abs(signed).min(0), 1e-3)

    def test_radius_and_motion(self):
        scene = cbvh.Scene([cube_mesh(max_error=0)])
        points = [[0.5, 0.5, 0.5], [0.5, 0.5, 0.9], [0.5, 0.5, 1.1], [0.5, 0.5, 3]]
        np.testing.assert_allclose(scene.distance(points, 0.25), [np.inf, 0.1, 0.1, np.inf], atol=1e-6)
        np.testing.assert_allclose(scene.signed_distance(points, 0.25), [np.inf, 0.1, -0.1, -np.inf], atol=1e-6)
        moving = cbvh.build(rising_model(), "cvert", 4)
        np.testing.assert_allclose(moving.distance([0.5, 0.5, 1], time=[0, 0.5, 1]), [1, 0.75, 0.5], atol=1e-5)

    def test_open_surfaces_raise_nothing(self):
        scene = cbvh.build(sheet(), "ctile", 3)
        self.assertEqual(scene.contains([[0.5, 0.5, 1], [0.5, 0.5, -1]]).shape, (2,))

    def test_errors(self):
        scene = cbvh.build(sheet(), "ctile", 3)
        for call in (scene.distance, scene.signed_distance, scene.contains):
            with self.assertRaisesRegex(ValueError, "points"):
                call([0, 0])
            with self.assertRaisesRegex(ValueError, "points: .*coordinate nan"):
                call([0, np.nan, 0])
            with self.assertRaisesRegex(ValueError, "time"):
                call([0, 0, 0], time=2)
        grid = cbvh.build(sheet(), "grid", 3)
        for call in (grid.distance, grid.signed_distance, grid.contains):
            with self.assertRaisesRegex(cbvh.Error, "cTILE or cVERT"):
                call([0, 0, 0])
        with tempfile.TemporaryDirectory() as folder:
            cbvh.build(sheet(), "cvoxel", 3).save(folder + "/sheet")
            loaded = cbvh.load(folder + "/sheet")
            with self.assertRaisesRegex(cbvh.Error, "cVERT"):
                loaded.distance([0, 0, 0])
            self.assertTrue(loaded.intersect([0.5, 0.5, 1], [0, 0, -1]).hit)


def rising_model(poses=1):
    """The sheet, which rises by one half from time 0 to 1."""
    vertices, _ = sheet_arrays()
    return cbvh.Model(sheet(), poses=[vertices + [0, 0, 0.5 * (i + 1) / poses] for i in range(poses)])


class Motion(unittest.TestCase):
    def test_rays_have_times(self):
        origins, directions = rays_from_above()
        times = np.linspace(0, 1, origins[..., 0].size).reshape(origins.shape[:-1])
        for poses in (1, 4):
            for name in ("grid", "cvert"):
                with self.subTest(name, poses=poses):
                    scene = cbvh.build(rising_model(poses), name, 4)
                    np.testing.assert_allclose(scene.intersect(origins, directions).t, 1, atol=1e-5)
                    np.testing.assert_allclose(
                        scene.intersect(origins, directions, time=times).t, 1 - 0.5 * times, atol=1e-5
                    )
                    reached = scene.occluded(origins, directions, tfar=0.75, time=times)
                    np.testing.assert_array_equal(reached[times > 0.501], True)
                    np.testing.assert_array_equal(reached[times < 0.499], False)

    def test_stored_triangles_have_times(self):
        scene = cbvh.build(rising_model(), "cvert", 4)
        hits = scene.intersect(*rays_from_above(), time=0.25)
        np.testing.assert_allclose(scene.triangles(hits, time=0.25)[..., 2], 0.125, atol=1e-5)
        np.testing.assert_allclose(scene.stored_mesh(time=1)["vertices"][:, 2], 0.5, atol=1e-5)
        np.testing.assert_allclose(scene.stored_mesh()["vertices"][:, 2], 0, atol=1e-5)
        for time in (-1, -0.1, 1.1, 1.5, np.nan):
            with self.assertRaisesRegex(ValueError, f"time: .*{time}.* 0 to 1"):
                scene.triangles(hits, time=time)
            with self.assertRaisesRegex(ValueError, f"time: .*{time}.* 0 to 1"):
                scene.stored_mesh(time=time)
            for trace in (scene.intersect, scene.occluded):
                with self.assertRaisesRegex(ValueError, f"time: .*{time}.* 0 to 1"):
                    trace([0, 0, 1], [0, 0, -1], time=[0.5, time])

    def test_models_report_their_steps(self):
        self.assertEqual([cbvh.Model(sheet()).steps, rising_model(4).steps], [1, 5])
        self.assertEqual(cbvh.Model.generate("cube", motion="turn", steps=3).steps, 3)

    def test_invalid_motion_is_rejected(self):
        with self.assertRaisesRegex(ValueError, r"poses: .*\(2, 35, 3\).*\(steps, 36, 3\)"):
            cbvh.Model(sheet(), poses=np.zeros((2, 35, 3)))
        with self.assertRaisesRegex(cbvh.Error, r"(?<!-)\bmotion 'jump'.*turn.*bend.*twist.*walk"):
            cbvh.Model.generate("cube", motion="jump")
        with self.assertRaisesRegex(cbvh.Error, "NAIVE .*move"):
            cbvh.build(rising_model(), "naive", 3)


class Stored(unittest.TestCase):
    def test_triangles_match_hits(self):
        scene = cbvh.build(bumpy_model(), "cvert", 4)
        origins, directions = rays_from_above()
        hits = scene.intersect(origins, directions)
        triangles = scene.triangles(hits)
        self.assertEqual(triangles.shape, (24, 24, 3, 3))
        points = origins + hits.t[..., None] * np.asarray(directions)
        normals = np.cross(triangles[..., 1, :] - triangles[..., 0, :], triangles[..., 2, :] - triangles[..., 0, :])
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        np.testing.assert_allclose(np.sum((points - triangles[..., 0, :]) * normals, -1), 0, atol=1e-5)
        self.assertTrue((points >= triangles.min(-2) - 1e-5).all() and (points <= triangles.max(-2) + 1e-5).all())
        self.assertTrue(np.isnan(scene.triangles(scene.intersect([5, 5, 1], [0, 0, -1]))).all())

    def test_tessellation_matches_the_surface(self):
        scene = cbvh.build(bumpy_model(), "cvert", 4)
        mesh = scene.stored_mesh()
        vertices, quads = mesh["vertices"], mesh["quads"]
        self.assertEqual(len(quads), scene.statistics()["quads"])
        self.assertEqual(sorted(set(mesh["primID"].tolist())), list(range(25)))
        self.assertLess(quads.max(), len(vertices))
        diagonals = [vertices[quads[:, i + 2], :2] - vertices[quads[:, i], :2] for i in (0, 1)]
        area = np.abs(np.linalg.det(np.stack(diagonals, axis=1).astype(np.float64))).sum() / 2
        self.assertTrue(0.8 < area <= 1.0001, area)
        hits = scene.intersect(*rays_from_above())
        corners = scene.triangles(hits).reshape(-1, 3)
        self.assertTrue(set(map(tuple, corners.tolist())) <= set(map(tuple, vertices.tolist())))

    def test_only_cvert_returns_triangles(self):
        scene = cbvh.build(sheet(), "cleaf", 3)
        with self.assertRaisesRegex(cbvh.Error, "cLEAF.*cVERT"):
            scene.triangles(scene.intersect(*rays_from_above()))
        with self.assertRaisesRegex(cbvh.Error, "cLEAF.*cVERT"):
            scene.stored_mesh()


class Rays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = cbvh.build(bumpy_model(), "cvert", 4)

    def test_arrays_of_any_kind_give_the_same_rays(self):
        origins, directions = rays_from_above()
        expected = self.scene.intersect(origins, directions)
        self.assertGreater(np.ptp(expected.t), 0.01)
        unaligned = np.zeros(origins.nbytes + 1, np.uint8)[1:].view(np.float32).reshape(origins.shape)
        unaligned[...] = origins
        for o, d in (
            (origins.astype(np.float64), directions),
            (origins.astype(">f8"), np.ascontiguousarray(directions)),
            (unaligned, directions.astype(np.float16)),
            (origins[::-1].copy()[::-1], directions[:1, :1]),
            (np.asfortranarray(origins), np.asfortranarray(directions)),
            (np.repeat(origins, 2, 1)[:, ::2], directions.astype(np.int64)),
            (origins.tolist(), (0, 0, -1)),
            (origins, directions.astype(">f4")),
        ):
            hits = self.scene.intersect(o, d)
            self.assertEqual(hits.shape, (24, 24))
            np.testing.assert_array_equal(hits.t, expected.t)
            np.testing.assert_array_equal(hits.primID, expected.primID)

    def test_rays_are_broadcast(self):
        origin, directions = np.array([0.5, 0.5, 1]), np.array([[0, 0, -1], [0.1, 0, -1], [0, 0.2, -1]])
        one = self.scene.intersect(origin, directions)
        each = [self.scene.intersect(origin, d) for d in directions]
        self.assertEqual(one.shape, (3,))
        self.assertEqual(each[0].shape, ())
        np.testing.assert_array_equal(one.t, [hits.t for hits in each])
        limits = self.scene.intersect(origin, [0, 0, -1], tfar=[[0.5], [2]], tnear=[0, 1.5, 0])
        self.assertEqual(limits.shape, (2, 3))
        np.testing.assert_array_equal(limits.hit, [[False, False, False], [True, False, True]])
        self.assertEqual(self.scene.intersect(np.zeros((0, 3)), [0, 0, 1]).t.shape, (0,))
        self.assertEqual(self.scene.occluded(np.zeros((2, 0, 3)), [0, 0, 1]).shape, (2, 0))

    def test_hits_do_not_depend_on_the_number_of_threads(self):
        rays = rays_from_above(200, -0.5, 1.5)
        one, all_ = (self.scene.intersect(*rays, threads=n) for n in (1, 0))
        np.testing.assert_array_equal(one.t, all_.t)
        np.testing.assert_array_equal(self.scene.occluded(*rays), one.hit)
        self.assertEqual(self.scene.occluded(*rays).dtype, bool)
        self.assertLess(one.hit.sum(), one.hit.size)

    def test_any_hit_respects_tnear_and_tfar(self):
        found = self.scene.occluded([0.5, 0.5, 1], [0, 0, -1], tnear=[0, 1.5], tfar=[0.5, np.inf])
        self.assertEqual(found.tolist(), [False, False])
        found = self.scene.occluded([0.5, 0.5, 1], [0, 0, -1], tfar=[-1, -np.inf, np.nan, 2])
        self.assertEqual(found.tolist(), [False, False, False, True])
        self.assertTrue(self.scene.occluded([0.5, 0.5, 1], [0, 0, -1])[()])

    def test_invalid_arrays_are_reported_by_name(self):
        scene = self.scene
        for error, text, arguments in (
            (ValueError, r"origins: .*\(2,\).*\(\.\.\., 3\)", ([0, 0], [0, 0, 1])),
            (ValueError, r"directions: .*\(\).*\(\.\.\., 3\)", ([0, 0, 0], 1.0)),
            (ValueError, r"origins .*\(2,\).*directions .*\(3,\)", (np.zeros((2, 3)), np.ones((3, 3)))),
            (TypeError, "tfar: .*<U3", ([0, 0, 0], [0, 0, 1], 0, "far")),
            (TypeError, "origins: .*object", (None, [0, 0, 1])),
        ):
            for query in (scene.intersect, scene.occluded):
                with self.subTest(text), self.assertRaisesRegex(error, text):
                    query(*arguments)
        with self.assertRaisesRegex(ValueError, "threads: .*-1"):
            scene.intersect([0, 0, 0], [0, 0, 1], threads=-1)
        with self.assertRaisesRegex(cbvh.Error, "packet5"):
            scene.trace_seconds([0, 0, 0], [0, 0, 1], mode="packet5")

    def test_every_mode_of_embree_is_timed(self):
        rays = rays_from_above(64)
        for query in ("closest", "any"):
            for mode in ("single", "packet4", "packet8", "packet16", "stream"):
                self.assertGreater(self.scene.trace_seconds(*rays, query=query, mode=mode, passes=4), 0)


class Building(unittest.TestCase):
    def test_statistics_describe_the_build(self):
        model, kept = bumpy_model(), {}
        for name in REPRESENTATIONS:
            scene = cbvh.build(model, name, 5)
            s = kept[name] = scene.statistics()
            self.assertEqual(s["quads"], 25 * 32 * 32)
            self.assertEqual(s["quads"], model.num_quads(5))
            self.assertEqual(s["representation"], scene.representation)
            self.assertAlmostEqual(s["bytes_per_quad"], s["live_bytes"] / s["quads"])
            self.assertGreaterEqual(s["peak_bytes"], s["live_bytes"])
            self.assertEqual("compression" in s, name not in ("naive", "naive-compact", "grid"))
            if "compression" in s:
                c = s["compression"]
                self.assertEqual(c["quads"] + c["uncompressed_quads"], s["quads"])
                self.assertLessEqual(c["node_bytes"] + c["leaf_bytes"] + c["header_bytes"], s["live_bytes"])
        self.assertLess(kept["cvert"]["live_bytes"], kept["cgrid"]["live_bytes"])
        self.assertLess(kept["cgrid"]["live_bytes"], kept["grid"]["live_bytes"])
        self.assertLess(kept["grid"]["live_bytes"], kept["naive-compact"]["live_bytes"])
        self.assertLess(kept["naive-compact"]["live_bytes"], kept["naive"]["live_bytes"])

    def test_repr_contains_long_names(self):
        vertices, faces = sheet_arrays()
        for name in ("x" * 1000, "ä" * 500, "xä" * 300):
            text = repr(cbvh.build(cbvh.Cage(vertices, faces, name=name), "cvert", 2))
            self.assertIn(f"'{name}'", text)
            self.assertIn("400 quads", text)

    def test_cage_can_be_used_as_model_without_displacement(self):
        scene = cbvh.build(sheet(), level=3)
        self.assertFalse(scene.model.is_displaced)
        self.assertEqual(scene.representation, "cTILE")
        self.assertEqual(scene.level, 3)

    def test_requested_frame_levels_are_used(self):
        label = lambda *a, **o: cbvh.build(sheet(), *a, level=4, **o).representation
        self.assertEqual(label("cleaf"), "cLEAF")
        self.assertEqual(label("cleaf", frame_level=1), "cLEAF^1")
        self.assertEqual(label("cbvh.leaf", frame_level=1), "cLEAF^1")
        self.assertEqual(label("Leaf-only:1"), "cLEAF-only^1")
        self.assertEqual(label("cVoxel^3", frame_level=1), "cVOXEL^3")
        self.assertEqual(label("cgrid", frame_level="auto"), "cGRID")
        blocks = [
            cbvh.build(sheet(), "cvoxel", 4, frame_level=n).statistics()["compression"]["blocks"] for n in (0, 1, 2)
        ]
        self.assertEqual(blocks, [25, 100, 400])

    def test_fallback_faces_are_selected_by_name(self):
        exact = lambda name: cbvh.build(cbvh.Model.generate("cube"), name, 3).statistics()["compression"][
            "fallback_quads_share"
        ]
        self.assertGreater(exact("cleaf"), 0)
        self.assertEqual(exact("cleaf-only"), 0)
        with self.assertRaises(TypeError):
            cbvh.build(sheet(), "cleaf", 3, fallback_faces=False)

    def test_error_bounds_hold(self):
        model = bumpy_model()
        spacing = lambda **o: cbvh.build(model, "cvert", 4, **o).statistics()["compression"]["max_vertex_spacing"]
        free, bound = spacing(), 1e-5
        self.assertGreater(free, bound)
        self.assertLessEqual(spacing(max_error=bound), bound)
        camera = cbvh.build(model, "grid", 4).camera("full", (4000, 4000))
        self.assertLess(spacing(max_pixel_error=0.001, camera=camera), free)

    def test_invalid_arguments_are_reported_by_name(self):
        for error, text, options in (
            (cbvh.Error, r"(?<!-)\brepresentation 'cmesh'.*naive", {"representation": "cmesh"}),
            (ValueError, "representation: .*'grid,cvert'.*several", {"representation": "grid,cvert"}),
            (cbvh.Error, "^level 9 .* 0 to 8", {"level": 9}),
            (cbvh.Error, "^level -1 .* 0 to 8", {"level": -1}),
            (cbvh.Error, "frame level '9'.* 0 to 8.*auto", {"representation": "cleaf", "frame_level": 9}),
            (ValueError, "max_error: .*-1", {"max_error": -1}),
            (ValueError, "^max_pixel_error: .*camera", {"max_pixel_error": 1}),
            (cbvh.Error, "^threads -1 ", {"threads": -1}),
            (cbvh.Error, r"(?<!-)\bisa 'neon'", {"isa": "neon"}),
            (cbvh.Error, r"(?<!-)\bdevice 'abacus'.*cpu.*vulkan.*ray-query", {"device": "abacus"}),
            (TypeError, "progress: .*None .*callable", {"progress": 3}),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                cbvh.build(sheet(), **options)
        with self.assertRaises(TypeError):
            cbvh.build("body.obj")

    def test_insufficient_memory_is_detected_before_the_build(self):
        with self.assertRaisesRegex(MemoryError, "NAIVE .* 5898.2 million quads"):
            cbvh.build(sheet(300), "naive", 8)


class Cameras(unittest.TestCase):
    def test_camera_looks_at_its_target(self):
        camera = cbvh.Camera((0, 0, 2), (0, 0, 0), fov=90, size=(5, 3))
        origins, directions = cbvh.primary_rays(camera)
        self.assertEqual(directions.shape, (3, 5, 3))
        np.testing.assert_array_equal(origins, np.broadcast_to([0, 0, 2], (3, 5, 3)))
        np.testing.assert_allclose(directions[1, 2], [0, 0, -1], atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1, atol=1e-6)
        self.assertGreater(directions[0, 2, 1], 0)  # row 0 is the top row
        self.assertAlmostEqual(camera.pixel_size, 2 / 3, places=6)

    def test_coherent_rays_are_primary_rays_in_tiles(self):
        camera = cbvh.Camera((0, 0, 2), (0, 0, 0), size=(24, 16))
        _, pixels = cbvh.primary_rays(camera)
        _, tiles = cbvh.coherent_rays(camera)
        np.testing.assert_array_equal(tiles[:64].reshape(8, 8, 3), pixels[:8, :8])
        np.testing.assert_array_equal(tiles[64:128].reshape(8, 8, 3), pixels[:8, 8:16])
        self.assertEqual(len(cbvh.coherent_rays(camera, 100)[0]), 128)

    def test_full_view_shows_everything(self):
        scene = cbvh.build(cbvh.Model.generate("cube"), "grid", 4)
        camera = scene.camera("full", (64, 48))
        hit = scene.intersect(*cbvh.primary_rays(camera)).hit
        self.assertTrue(hit.any())
        self.assertFalse(hit[0].any() or hit[-1].any() or hit[:, 0].any() or hit[:, -1].any())
        self.assertGreater(scene.intersect(*cbvh.primary_rays(scene.camera("close", (64, 48)))).hit.mean(), hit.mean())

    def test_bounced_rays_leave_the_surface(self):
        scene = cbvh.build(sheet(), "grid", 4)
        origins, directions = rays_from_above()
        hits = scene.intersect(origins, directions)
        o, d = cbvh.bounce_rays(hits, origins, directions, offset=0.01)
        self.assertEqual(o.shape, (24 * 24, 3))
        np.testing.assert_allclose(o[:, 2], 0.01, atol=1e-5)
        self.assertGreaterEqual(d[:, 2].min(), 0)
        self.assertAlmostEqual(d[:, 2].mean(), 2 / 3, delta=0.05)  # for a cosine distribution
        again, other = (cbvh.bounce_rays(hits, origins, directions, offset=0.01, seed=s)[1] for s in (1, 2))
        np.testing.assert_array_equal(d, again)
        self.assertFalse(np.array_equal(d, other))
        self.assertEqual(len(cbvh.bounce_rays(hits, origins, directions, offset=0, count=7)[0]), 7)

    def test_invalid_arguments_are_reported_by_name(self):
        for text, arguments in (
            ("look_at: .*eye", ((0, 0, 0), (0, 0, 0))),
            (r"eye: .*\(2,\)", ((0, 0), (0, 0, 1))),
            ("eye: .*finite", ((0, 0, np.nan), (0, 0, 1))),
            ("look_at: .*1e.30", ((0, 0, 1e30), (0, 0, 0))),
            ("up: .* 0:", ((0, 0, 0), (0, 0, 1), (0, 0, 0))),
            ("fov: .* 180.* 180", ((0, 0, 0), (0, 0, 1), (0, 1, 0), 180)),
            (r"size: .*\(0, 3\)", ((0, 0, 0), (0, 0, 1), (0, 1, 0), 35, (0, 3))),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                cbvh.Camera(*arguments)
        scene = cbvh.build(sheet(), "grid", 3)
        with self.assertRaisesRegex(ValueError, "view: .*'top'.*'full'.*'close'"):
            scene.camera("top")
        hits = scene.intersect([[0.5, 0.5, 1]], [0, 0, -1])
        with self.assertRaisesRegex(ValueError, "hits: .* 1 .* 576.*origins"):
            cbvh.bounce_rays(hits, *rays_from_above(), offset=0)
        for offset in (-1, np.nan):
            with self.assertRaisesRegex(ValueError, "offset: .*(-1|nan).* 0"):
                cbvh.bounce_rays(hits, [[0.5, 0.5, 1]], [0, 0, -1], offset=offset)


if __name__ == "__main__":
    unittest.main()
