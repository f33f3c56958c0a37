# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Ray queries of trimesh on meshes that libembree_cbvh stores compressed.

    mesh = trimesh.load("scan.ply")
    mesh.ray = RayMeshIntersector(mesh)
    mesh.ray.intersects_first(origins, directions)

The methods, their arguments and results are those of trimesh.ray.ray_pyembree. Hits are on the triangles of the mesh:
vertices are stored exactly, as floats of 32 bits, like in embreex.

It saves memory: docs/meshes.md has bytes per triangle, see its column "lossless". It does not help with small meshes,
and it does not save time: rays at irregular meshes take longer than in Embree, and a query runs on one thread.
trimesh's own arrays, 36 bytes per triangle of a closed mesh, stay.
"""

import ctypes
import functools
import weakref
from pathlib import Path

import numpy as np

__all__ = ["RayMeshIntersector"]

NO_HIT = 0xFFFFFFFF
FEWEST_COMPRESSED = 256  # triangles, see docs/meshes.md
PACKET = 16
# Rows of RTCRayHit16
ORIGIN, NEAR, DIRECTION, FAR, MASK, PRIMITIVE, GEOMETRY, ROWS = slice(0, 3), 3, slice(4, 7), 8, 9, 17, 18, 20
HANDLE = ctypes.c_void_p


class Vertices(ctypes.Structure):
    """CbvhVertices"""

    _fields_ = [
        ("num_vertices", ctypes.c_size_t),
        ("stride", ctypes.c_size_t),
        ("steps", ctypes.POINTER(ctypes.c_void_p)),
        ("num_steps", ctypes.c_uint),
        ("start_time", ctypes.c_float),
        ("end_time", ctypes.c_float),
    ]


class Mesh(ctypes.Structure):
    """CbvhMesh"""

    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("vertices_per_face", ctypes.c_uint),
        ("num_faces", ctypes.c_size_t),
        ("indices", ctypes.c_void_p),
        ("vertices", Vertices),
    ]


class Statistics(ctypes.Structure):
    """CbvhGroupStatistics"""

    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("bytes", ctypes.c_size_t),
        ("num_quads", ctypes.c_size_t),
        ("num_moving_quads", ctypes.c_size_t),
        ("num_invalid_quads", ctypes.c_size_t),
        ("max_vertex_deviation", ctypes.c_float),
    ]


@functools.lru_cache(maxsize=None)
def library():
    """Loads the library of the wheel that contains this file, or the one that the dynamic linker finds."""
    of_wheel = sorted(Path(__file__).parent.glob("lib/libembree_cbvh-*.so*"))
    opened = ctypes.CDLL(str(of_wheel[0]) if of_wheel else "libembree_cbvh.so.0")
    arguments = {
        "cbvhNewContext": [ctypes.c_char_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.POINTER(HANDLE)],
        "cbvhNewSurface": [HANDLE, ctypes.POINTER(HANDLE)],
        "cbvhSetSurfaceMesh": [HANDLE, ctypes.POINTER(Mesh)],
        "cbvhSetSurfaceLossless": [HANDLE, ctypes.c_int],
        "cbvhCommitSurface": [HANDLE, ctypes.c_void_p, ctypes.c_void_p],
        "cbvhNewGroup": [HANDLE, ctypes.POINTER(HANDLE), ctypes.c_size_t, ctypes.POINTER(HANDLE)],
        "cbvhCommitGroup": [HANDLE],
        "cbvhGetGroupStatistics": [HANDLE, ctypes.POINTER(Statistics)],
        "cbvhIntersect16": [HANDLE, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p],
        "cbvhReleaseContext": [HANDLE],
        "cbvhReleaseSurface": [HANDLE],
        "cbvhReleaseGroup": [HANDLE],
    }
    for name, types in arguments.items():
        function = getattr(opened, name)
        function.argtypes = types
        if "Release" in name:
            function.restype = None
        elif "Intersect" in name:
            function.restype = ctypes.c_uint
        else:
            function.errcheck = check
    opened.cbvhGetErrorText.restype = ctypes.c_char_p
    return opened


def check(code, function, _):
    if code:
        raise RuntimeError(f"{function.__name__}: {library().cbvhGetErrorText().decode()}")


def aligned_zeros(shape, dtype):
    """Kernels require packets aligned to 64 bytes."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape)) * dtype.itemsize
    raw = np.zeros(size + 64, np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start : start + size].view(dtype).reshape(shape)


class CompressedMesh:
    """Triangles in a group of their own, traced with float32 rays."""

    def __init__(self, vertices, faces):
        # Embree reads 4 bytes beyond the last vertex.
        points = np.zeros((len(vertices) + 1, 3), np.float32)
        points[:-1] = vertices
        indices = np.ascontiguousarray(faces, dtype=np.uint32)
        steps = (ctypes.c_void_p * 1)(points.ctypes.data)
        mesh = Mesh(ctypes.sizeof(Mesh), 3, len(indices), indices.ctypes.data, Vertices(len(vertices), 12, steps, 1))
        api = library()
        context, surface = HANDLE(), HANDLE()
        self.group = HANDLE()
        api.cbvhNewContext(None, None, None, ctypes.byref(context))
        try:
            api.cbvhNewSurface(context, ctypes.byref(surface))
            api.cbvhSetSurfaceMesh(surface, mesh)
            api.cbvhSetSurfaceLossless(surface, 1)
            api.cbvhCommitSurface(surface, None, None)
            api.cbvhNewGroup(context, ctypes.byref(surface), 1, ctypes.byref(self.group))
            weakref.finalize(self, api.cbvhReleaseGroup, self.group)
            api.cbvhCommitGroup(self.group)
        finally:  # the group keeps what it needs
            if surface:
                api.cbvhReleaseSurface(surface)
            api.cbvhReleaseContext(context)

    def memory_bytes(self):
        result = Statistics(ctypes.sizeof(Statistics))
        library().cbvhGetGroupStatistics(self.group, result)
        return result.bytes

    def closest(self, origins, directions, near):
        """Returns the triangle, or -1, and the distance of the closest hit of each ray beyond `near`."""
        count = len(origins)
        packets = -(-count // PACKET)
        rays = aligned_zeros((packets, ROWS, PACKET), np.float32)
        numbers = rays.view(np.uint32)
        valid = aligned_zeros((packets, PACKET), np.int32)

        def rows(values):  # (count, k) to (packets, k, PACKET)
            padded = np.zeros((packets * PACKET, values.shape[1]), np.float32)
            padded[:count] = values
            return padded.reshape(packets, PACKET, values.shape[1]).transpose(0, 2, 1)

        rays[:, ORIGIN] = rows(origins)
        rays[:, DIRECTION] = rows(directions)
        rays[:, NEAR : NEAR + 1] = rows(near[:, None])
        rays[:, FAR] = np.inf
        numbers[:, MASK] = numbers[:, PRIMITIVE] = numbers[:, GEOMETRY] = NO_HIT
        valid.reshape(-1)[:count] = -1

        intersect, group = library().cbvhIntersect16, self.group
        ray, ray_bytes = rays.ctypes.data, rays.strides[0]
        mask, mask_bytes = valid.ctypes.data, valid.strides[0]
        for packet in range(packets):
            intersect(group, mask + packet * mask_bytes, ray + packet * ray_bytes, None)
        triangles = numbers[:, PRIMITIVE].reshape(-1)[:count].astype(np.int64)
        triangles[triangles == NO_HIT] = -1
        return triangles, rays[:, FAR].reshape(-1)[:count].copy()


class FewTriangles:
    """Tests all triangles of a mesh that the library does not compress."""

    RAYS = 2048  # per step, which limits memory

    def __init__(self, vertices, faces):
        corners = np.asarray(vertices, dtype=np.float64)[np.asarray(faces, dtype=np.int64).reshape(-1, 3)]
        self.corner, b, c = np.moveaxis(corners, 1, 0)
        self.edges = b - self.corner, c - self.corner

    def memory_bytes(self):
        return 3 * self.corner.nbytes

    def closest(self, origins, directions, near):
        triangles = np.full(len(origins), -1, np.int64)
        distances = np.full(len(origins), np.inf, np.float32)
        if len(self.corner):
            for start in range(0, len(origins), self.RAYS):
                part = slice(start, start + self.RAYS)
                t = self._distances(origins[part, None], directions[part, None], near[part, None])
                nearest = t.argmin(axis=1)
                distances[part] = t[np.arange(len(t)), nearest]
                triangles[part] = np.where(np.isfinite(distances[part]), nearest, -1)
        return triangles, distances

    def _distances(self, origins, directions, near):
        """Moeller and Trumbore 1997; infinity where a ray misses."""
        first, second = self.edges
        across = np.cross(directions, second)
        from_corner = origins - self.corner
        around = np.cross(from_corner, first)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / (first * across).sum(axis=-1)
            u = (from_corner * across).sum(axis=-1) * scale
            v = (directions * around).sum(axis=-1) * scale
            t = (second * around).sum(axis=-1) * scale
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= near)
        return np.where(hit, t, np.inf)


class RayMeshIntersector:
    """The interface of trimesh.ray.ray_pyembree.RayMeshIntersector."""

    def __init__(self, geometry, scale_to_box=True):
        """geometry: a Trimesh. scale_to_box: scales the mesh to a size of about 100 before tracing."""
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._built = None

    def _scene(self):
        """The compressed mesh, its origin and its scale. Built again after a change of the mesh."""
        key = hash(self.mesh)
        if self._built is None or self._built[0] != key:
            vertices = np.asarray(self.mesh.vertices, dtype=np.float64)
            used = np.zeros(len(vertices), bool)
            used[np.asarray(self.mesh.faces, dtype=np.int64)] = True
            corners = vertices[used & np.isfinite(vertices).all(axis=1)]
            origin, size = np.zeros(3), 0.0
            if len(corners):
                origin = corners.min(axis=0)
                size = np.linalg.norm(corners.max(axis=0) - origin)
            scale = 100 / size if self._scale_to_box and size > 0 else 1.0
            kind = CompressedMesh if len(self.mesh.faces) >= FEWEST_COMPRESSED else FewTriangles
            self._built = key, kind((vertices - origin) * scale, self.mesh.faces), origin, scale
        return self._built[1:]

    def _prepare(self, ray_origins, ray_directions):
        scene, origin, scale = self._scene()
        origins = np.array(ray_origins, dtype=np.float64)
        directions = np.array(ray_directions, dtype=np.float64)
        if origins.shape != directions.shape:
            raise ValueError(
                f"ray_origins has shape {origins.shape}, ray_directions {directions.shape}: expected equal shapes"
            )
        lengths = np.linalg.norm(directions, axis=1, keepdims=True)
        directions /= np.where(lengths > 0, lengths, 1)
        return scene, (origins - origin) * scale, directions, origin, scale

    def memory_bytes(self):
        """Memory of the triangles and their tree."""
        return self._scene()[0].memory_bytes()

    def intersects_first(self, ray_origins, ray_directions):
        """Returns (n,) int64: the first triangle that each ray hits, or -1."""
        scene, origins, directions, _, _ = self._prepare(ray_origins, ray_directions)
        return scene.closest(origins, directions, np.zeros(len(origins), np.float32))[0]

    def intersects_any(self, ray_origins, ray_directions):
        """Returns (n,) bool: True if the ray hits the mesh."""
        return self.intersects_first(ray_origins, ray_directions) != -1

    def intersects_id(
        self, ray_origins, ray_directions, multiple_hits=True, max_hits=20, return_locations=False
    ):
        """Returns the triangles and the rays of all hits, and if requested their locations.

        Hits of one ray at the same distance, for example at an edge, count as one.
        """
        scene, origins, directions, origin, scale = self._prepare(ray_origins, ray_directions)
        active = np.arange(len(origins))
        near = np.zeros(len(origins), np.float32)
        triangles, rays = [], []
        for _ in range(max_hits if multiple_hits else 1):
            found, distances = scene.closest(origins[active], directions[active], near[active])
            hit = found != -1
            active = active[hit]
            if len(active) == 0:
                break
            triangles.append(found[hit])
            rays.append(active)
            # Tracing the same ray again returns the same distance for the same triangle.
            near[active] = np.nextafter(distances[hit], np.float32(np.inf))
        index_tri = np.concatenate(triangles) if triangles else np.zeros(0, np.int64)
        index_ray = np.concatenate(rays) if rays else np.zeros(0, np.int64)
        if not return_locations:
            return index_tri, index_ray
        return index_tri, index_ray, self._locations(index_tri, origins[index_ray] / scale + origin,
                                                     directions[index_ray])

    def intersects_location(self, ray_origins, ray_directions, multiple_hits=True):
        """Returns locations (m, 3), rays (m,) and triangles (m,) of all hits."""
        index_tri, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits=multiple_hits, return_locations=True
        )
        return locations, index_ray, index_tri

    def contains_points(self, points):
        """Returns (n,) bool: True if the point is inside of the mesh, which must be closed."""
        from trimesh.ray.ray_util import contains_points

        return contains_points(self, points)

    def _locations(self, triangles, origins, directions):
        """Where rays hit the planes of their triangles, in double precision."""
        corners = np.asarray(self.mesh.vertices, dtype=np.float64)[np.asarray(self.mesh.faces)[triangles]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        along = (normals * directions).sum(axis=1)
        distances = (normals * (corners[:, 0] - origins)).sum(axis=1) / along
        return origins + distances[:, None] * directions

    def __getstate__(self):
        return dict(self.__dict__, _built=None)
