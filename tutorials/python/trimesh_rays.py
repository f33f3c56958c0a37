# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Ray queries and closest points of trimesh on meshes that libembree_cbvh stores compressed.

    mesh = trimesh.load("scan.ply")
    mesh.ray = RayMeshIntersector(mesh)
    mesh.ray.intersects_first(origins, directions)
    closest, distance, triangles = ProximityQuery(mesh).on_surface(points)

The methods, their arguments and results are those of trimesh.ray.ray_pyembree, which returns 20 hits per ray at most:
here, all hits are returned unless the caller sets max_hits. Hits are on the triangles of the mesh: vertices are stored
exactly, as floats of 32 bits, like in embreex.

It saves memory: docs/meshes.md has bytes per triangle, see its column "lossless". It does not save time: rays at
irregular meshes take longer than in Embree, and a query runs on one thread. trimesh's own arrays, 36 bytes per triangle
of a closed mesh, stay.
"""

import ctypes
import functools
import itertools
import weakref
from pathlib import Path

import numpy as np

__all__ = ["ProximityQuery", "RayMeshIntersector"]

NO_HIT = 0xFFFFFFFF
PACKET = 16
# Rows of RTCRayHit16, and words of RTCRayHit
ORIGIN, NEAR, DIRECTION, FAR, MASK, PRIMITIVE, GEOMETRY, ROWS = slice(0, 3), 3, slice(4, 7), 8, 9, 17, 18, 20
BEFORE_ALL = np.float32(-1)  # distance of no hit
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


class FilterArguments(ctypes.Structure):
    """CbvhFilterArguments"""

    _fields_ = [
        ("valid", ctypes.POINTER(ctypes.c_int)),
        ("user_ptr", ctypes.c_void_p),
        ("rays", ctypes.POINTER(ctypes.c_float)),
        ("hits", ctypes.c_void_p),
        ("count", ctypes.c_uint),
    ]


FilterFunction = ctypes.CFUNCTYPE(None, ctypes.POINTER(FilterArguments))


class Query(ctypes.Structure):
    """CbvhQuery"""

    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("flags", ctypes.c_uint),
        ("filter", FilterFunction),
        ("filter_user_ptr", ctypes.c_void_p),
    ]


class PointQuery(ctypes.Structure):
    """CbvhPointQuery"""

    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("point", ctypes.c_float * 3),
        ("time", ctypes.c_float),
        ("radius", ctypes.c_float),
        ("function", ctypes.c_void_p),
        ("user_ptr", ctypes.c_void_p),
    ]


# CbvhClosestPoint
CLOSEST_POINT = np.dtype(
    [
        ("point", np.float32, 3),
        ("distance", np.float32),
        ("normal", np.float32, 3),
        ("parameters", np.float32, 2),
        ("primitive", np.uint32),
        ("geometry", np.uint32),
    ]
)


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
        "cbvhIntersect1": [HANDLE, ctypes.c_void_p, ctypes.POINTER(Query)],
        "cbvhIntersect16": [HANDLE, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p],
        "cbvhPointQuery": [HANDLE, ctypes.POINTER(PointQuery), ctypes.c_void_p],
        "cbvhReleaseSurface": [HANDLE],
        "cbvhReleaseGroup": [HANDLE],
    }
    for name, types in arguments.items():
        function = getattr(opened, name)
        function.argtypes = types
        if "Release" in name:
            function.restype = None
        elif "Intersect" in name or "PointQuery" in name:
            function.restype = ctypes.c_uint
        else:
            function.errcheck = check
    opened.cbvhGetErrorText.restype = ctypes.c_char_p
    return opened


def check(code, function, _):
    if code:
        raise RuntimeError(f"{function.__name__}: {library().cbvhGetErrorText().decode()}")


@functools.lru_cache(maxsize=None)
def context():
    """Returns the context of all meshes, which lives as long as the process."""
    result = HANDLE()
    library().cbvhNewContext(None, None, None, ctypes.byref(result))
    return result


def after(distances):
    """The next floats of 32 bits."""
    return np.nextafter(distances, np.float32(np.inf))


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
        surface = HANDLE()
        self.group = HANDLE()
        api.cbvhNewSurface(context(), ctypes.byref(surface))
        try:
            api.cbvhSetSurfaceMesh(surface, mesh)
            api.cbvhSetSurfaceLossless(surface, 1)
            api.cbvhCommitSurface(surface, None, None)
            api.cbvhNewGroup(context(), ctypes.byref(surface), 1, ctypes.byref(self.group))
            weakref.finalize(self, api.cbvhReleaseGroup, self.group)
            api.cbvhCommitGroup(self.group)
        finally:  # the group keeps what it needs
            api.cbvhReleaseSurface(surface)

    def memory_bytes(self):
        result = Statistics(ctypes.sizeof(Statistics))
        library().cbvhGetGroupStatistics(self.group, result)
        return result.bytes

    def nearest(self, points):
        """Returns the closest triangle of each point, or -1 if there is none."""
        found = np.full(len(points), 0, CLOSEST_POINT)
        found["primitive"] = NO_HIT
        query = PointQuery(ctypes.sizeof(PointQuery), radius=np.inf)
        coordinates = np.frombuffer(query, np.float32, 3, PointQuery.point.offset)
        find, group, reference = library().cbvhPointQuery, self.group, ctypes.byref(query)
        for point, address in zip(points, range(found.ctypes.data, found.ctypes.data + found.nbytes, found.itemsize)):
            coordinates[:] = point
            find(group, reference, address)
        triangles = found["primitive"].astype(np.int64)
        triangles[triangles == NO_HIT] = -1
        return triangles

    def closest(self, origins, directions, previous):
        """Returns the triangle, or -1, and the distance of each ray's next hit.

        previous: distances of the rays' hits before, or BEFORE_ALL. Hits at this distance or the next float are the
        same hit as the one before.
        """
        near = np.where(previous < 0, np.float32(0), after(previous))
        triangles, distances = self._closest_from(origins, directions, near)
        # The kernels move hits of triangles in the plane of the ray to its start: it would hit them again and again.
        for i in np.nonzero((triangles != -1) & (previous >= 0) & (distances <= near))[0]:
            triangles[i], distances[i] = self._closest_beyond(origins[i], directions[i], near[i])
        return triangles, distances

    def _closest_beyond(self, origin, direction, near):
        """The same for one ray, without hits at `near`."""
        ray = aligned_zeros(ROWS, np.float32)
        ray[ORIGIN], ray[DIRECTION], ray[NEAR], ray[FAR] = origin, direction, near, np.inf
        numbers = ray.view(np.uint32)
        numbers[[MASK, PRIMITIVE, GEOMETRY]] = NO_HIT

        def reject(arguments):
            if arguments.contents.rays[FAR] <= near:
                arguments.contents.valid[0] = 0

        query = Query(ctypes.sizeof(Query), 0, FilterFunction(reject))
        if not library().cbvhIntersect1(self.group, ray.ctypes.data, query):
            return -1, np.inf
        return numbers[PRIMITIVE], ray[FAR]

    def _closest_from(self, origins, directions, near):
        """The same for hits at `near` and beyond."""
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


class NoTriangles:
    """A mesh without triangles, which the library rejects."""

    def memory_bytes(self):
        return 0

    def nearest(self, points):
        return np.full(len(points), -1, np.int64)

    def closest(self, origins, directions, previous):
        return np.full(len(origins), -1, np.int64), np.full(len(origins), np.inf, np.float32)


class Placement:
    """Between the units of a mesh and those of its scene, in which the mesh's box begins at 0."""

    # Around the box, as a part of its diagonal. Floats there are as precise as inside, and of rays almost in the plane
    # of a triangle more hit than if they started at the box itself.
    MARGIN = 0.25
    ROUNDING = 1e-6  # of vertices and rays in the scene, as a part of the diagonal; at most a few times 2**-24

    def __init__(self, corners, scale_to_box):
        self.origin, size = np.zeros(3), np.zeros(3)
        if len(corners):
            self.origin = corners.min(axis=0)
            size = corners.max(axis=0) - self.origin
        diagonal = np.linalg.norm(size)
        self.scale = 100 / diagonal if scale_to_box and diagonal > 0 else 1.0
        self.rounding = self.ROUNDING * diagonal * self.scale
        margin = self.MARGIN * diagonal
        self.lower, self.upper = np.full(3, -margin) * self.scale, (size + margin) * self.scale

    def to_scene(self, points):
        return (points - self.origin) * self.scale

    def to_mesh(self, points):
        return points / self.scale + self.origin

    def entries(self, origins, directions):
        """Distances along the rays, in the scene, to its box with a margin: 0 from inside, infinity for misses."""
        parallel = np.abs(directions) < 1e-300
        between = (origins >= self.lower) & (origins <= self.upper)
        with np.errstate(all="ignore"):
            first = (self.lower - origins) / directions
            last = (self.upper - origins) / directions
        first, last = np.minimum(first, last), np.maximum(first, last)
        first = np.where(parallel, np.where(between, -np.inf, np.inf), first)
        last = np.where(parallel, np.where(between, np.inf, -np.inf), last)
        entry = np.maximum(first.max(axis=1), 0)
        return np.where(entry <= last.min(axis=1), entry, np.inf)


def unit(vectors):
    """Directions of length 1; NaN for vectors of length 0 and vectors that are not finite."""
    with np.errstate(all="ignore"):
        vectors = vectors / np.abs(vectors).max(axis=-1, keepdims=True)  # so that no square under- or overflows
        return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def on_triangles(points, corners, tolerance):
    """True if the point is in the triangle or next to it; False for triangles of no area. corners: (n, 3, 3)."""
    near = (points >= corners.min(axis=1) - tolerance) & (points <= corners.max(axis=1) + tolerance)
    near = near.all(axis=1)
    following = np.roll(corners, -1, axis=1) - corners
    normals = unit(np.cross(following[:, 0], following[:, 1]))
    for i in range(3):
        outward = unit(np.cross(following[:, i], normals))
        near &= ((points - corners[:, i]) * outward).sum(axis=1) <= tolerance
    return near


def closest_on_triangles(points, corners):
    """Returns the closest points of triangles (n, 3, 3) in double precision: of edges, or projections to planes."""

    def of_edge(begin, end):
        edge = end - begin
        with np.errstate(all="ignore"):
            at = ((points - begin) * edge).sum(axis=1) / (edge * edge).sum(axis=1)
        return begin + np.clip(np.nan_to_num(at), 0, 1)[:, None] * edge

    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = np.cross(b - a, c - a)
    with np.errstate(all="ignore"):
        height = ((points - a) * normals).sum(axis=1) / (normals * normals).sum(axis=1)
    projected = points - height[:, None] * normals
    inside = np.isfinite(height)
    for begin, end in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(end - begin, projected - begin) * normals).sum(axis=1) >= 0
    candidates = np.stack([of_edge(a, b), of_edge(b, c), of_edge(c, a), np.where(inside[:, None], projected, np.inf)])
    with np.errstate(all="ignore"):
        nearest = np.linalg.norm(candidates - points, axis=2).argmin(axis=0)
    return candidates[nearest, np.arange(len(points))]


class RayMeshIntersector:
    """The interface of trimesh.ray.ray_pyembree.RayMeshIntersector."""

    def __init__(self, geometry, scale_to_box=True):
        """geometry: a Trimesh. scale_to_box: scales the mesh to a size of about 100 before tracing."""
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._built = None

    def _scene(self):
        """The compressed mesh and its placement. Built again after a change of the mesh."""
        key = hash(self.mesh)
        if self._built is None or self._built[0] != key:
            vertices = np.asarray(self.mesh.vertices, dtype=np.float64)
            used = np.zeros(len(vertices), bool)
            used[np.asarray(self.mesh.faces, dtype=np.int64)] = True
            placement = Placement(vertices[used & np.isfinite(vertices).all(axis=1)], self._scale_to_box)
            faces = self.mesh.faces
            scene = CompressedMesh(placement.to_scene(vertices), faces) if len(faces) else NoTriangles()
            self._built = key, scene, placement
        return self._built[1:]

    def _prepare(self, ray_origins, ray_directions):
        """Returns the scene, its placement, and the rays that reach its box: their indices, origins and directions.

        Origins far outside of the box move along their rays towards it, in double precision: far from the mesh, floats
        of 32 bits are coarser than its triangles.
        """
        scene, placement = self._scene()
        origins = np.array(ray_origins, dtype=np.float64)
        directions = np.array(ray_directions, dtype=np.float64)
        if origins.shape != directions.shape:
            raise ValueError(
                f"ray_origins has shape {origins.shape}, ray_directions {directions.shape}: expected equal shapes"
            )
        origins, directions = placement.to_scene(origins), unit(directions)
        entries = placement.entries(origins, directions)
        rays = np.nonzero(np.isfinite(entries))[0]
        directions = directions[rays]
        return scene, placement, rays, origins[rays] + entries[rays, None] * directions, directions

    def memory_bytes(self):
        """Memory of the triangles and their tree."""
        return self._scene()[0].memory_bytes()

    def intersects_first(self, ray_origins, ray_directions):
        """Returns (n,) int64: the first triangle that each ray hits, or -1."""
        scene, _, rays, origins, directions = self._prepare(ray_origins, ray_directions)
        first = np.full(len(ray_origins), -1, np.int64)
        first[rays] = scene.closest(origins, directions, np.full(len(origins), BEFORE_ALL))[0]
        return first

    def intersects_any(self, ray_origins, ray_directions):
        """Returns (n,) bool: True if the ray hits the mesh."""
        return self.intersects_first(ray_origins, ray_directions) != -1

    def intersects_id(self, ray_origins, ray_directions, multiple_hits=True, max_hits=None, return_locations=False):
        """Returns the triangles and the rays of all hits, and if requested their locations.

        max_hits: most hits per ray, the closest ones; None for all. Hits of one ray at the same distance, or at
        adjacent floats of 32 bits, for example at an edge, count as one.
        """
        scene, placement, rays, origins, directions = self._prepare(ray_origins, ray_directions)
        active = np.arange(len(origins))
        previous = np.full(len(origins), BEFORE_ALL)
        hits = []  # (triangles, indices of their rays, distances)
        for _ in range(1) if not multiple_hits else itertools.count() if max_hits is None else range(max_hits):
            found, distances = scene.closest(origins[active], directions[active], previous[active])
            hit = found != -1
            active = active[hit]
            if len(active) == 0:
                break
            hits.append((found[hit], active, distances[hit]))
            previous[active] = distances[hit]
        hits.append((np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.float32)))
        triangles, of_hits, distances = map(np.concatenate, zip(*hits))
        if not return_locations:
            return triangles, rays[of_hits]
        locations = self._locations(placement, triangles, origins[of_hits], directions[of_hits], distances)
        return triangles, rays[of_hits], locations

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

    def closest_points(self, points):
        """Returns the closest points of the mesh (n, 3), their distances (n,) and triangles (n,) int64.

        The closest triangle is that of the point rounded to floats of 32 bits in the scene; position and distance are
        computed with the triangle's own vertices in double precision. Without triangles: NaN, infinity and -1.
        """
        scene, placement = self._scene()
        points = np.array(points, dtype=np.float64).reshape(-1, 3)
        if not np.isfinite(points).all():
            raise ValueError("points are not finite")
        triangles = scene.nearest(placement.to_scene(points))
        found = triangles != -1
        closest, distances = np.full(points.shape, np.nan), np.full(len(points), np.inf)
        corners = np.asarray(self.mesh.vertices, dtype=np.float64)[np.asarray(self.mesh.faces)[triangles[found]]]
        first = corners[:, 0].copy()  # relative to it, differences of large coordinates are exact
        offsets = closest_on_triangles(points[found] - first, corners - first[:, None])
        distances[found] = np.linalg.norm(offsets - (points[found] - first), axis=1)
        closest[found] = first + offsets
        return closest, distances, triangles

    def _locations(self, placement, triangles, origins, directions, distances):
        """Where rays hit the planes of their triangles, in double precision.

        A triangle of no area, or of almost none, has no such plane. The location is then where the ray was traced to,
        with the precision of floats of 32 bits.
        """
        vertices = np.asarray(self.mesh.vertices, dtype=np.float64)
        corners = placement.to_scene(vertices[np.asarray(self.mesh.faces)[triangles]])
        normals = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        with np.errstate(all="ignore"):
            along = (normals * (corners[:, 0] - origins)).sum(axis=1) / (normals * directions).sum(axis=1)
            points = origins + along[:, None] * directions
            exact = on_triangles(points, corners, placement.rounding)
        traced = origins + distances[:, None].astype(np.float64) * directions
        return placement.to_mesh(np.where(exact[:, None], points, traced))

    def __getstate__(self):
        return dict(self.__dict__, _built=None)


class ProximityQuery:
    """The interface of trimesh.proximity.ProximityQuery, for points on the surface."""

    def __init__(self, mesh, rays=None):
        """mesh: a Trimesh. rays: its RayMeshIntersector, whose compressed mesh is used. None makes one."""
        self._rays = rays or RayMeshIntersector(mesh)

    def on_surface(self, points):
        """Returns the closest points of the mesh (n, 3), their distances (n,) and triangles (n,) int64."""
        return self._rays.closest_points(points)

    def signed_distance(self, points):
        """Returns (n,) distances, positive inside of the mesh, which must be closed, negative outside."""
        distances = self._rays.closest_points(points)[1]
        inside = self._rays.contains_points(points)
        return np.where(inside, distances, -distances)
