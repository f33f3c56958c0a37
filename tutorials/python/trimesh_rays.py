# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Ray queries and closest points of trimesh on meshes that embree_cbvh stores compressed.

    mesh = trimesh.load("scan.ply")
    mesh.ray = RayMeshIntersector(mesh)
    mesh.ray.intersects_first(origins, directions)
    closest, distance, triangles = ProximityQuery(mesh).on_surface(points)

The methods, their arguments and results are those of trimesh.ray.ray_pyembree, which returns 20 hits per ray at most:
here, all hits are returned unless the caller sets max_hits. Hits are on the triangles of the mesh: vertices are stored
exactly, as floats of 32 bits, like in embreex. Queries use all cores.

It saves memory: docs/measurements.md has bytes per triangle, see its column "lossless". trimesh's own arrays, 36 bytes
per triangle of a closed mesh, stay.
"""

from typing import Any, Dict, Optional, Tuple

import embree_cbvh as cbvh
import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ProximityQuery", "RayMeshIntersector"]

Doubles = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


class CompressedMesh:
    """Triangles in a scene of their own, traced with float32 rays. May have none."""

    def __init__(self, vertices: Doubles, faces: Integers) -> None:
        finite = np.isfinite(vertices).all(axis=1)
        self.triangles = np.nonzero(finite[faces].all(axis=1))[0]  # their indices in `faces`
        self.scene: Optional[cbvh.Scene] = None
        if len(self.triangles):
            points = np.where(finite[:, None], vertices, 0)
            self.scene = cbvh.Scene([cbvh.Mesh(points, faces[self.triangles], max_error=0)])

    def memory_bytes(self) -> int:
        return int(self.scene.statistics()["live_bytes"]) if self.scene else 0

    def triangles_of(self, hits: cbvh.Hits) -> Integers:
        """Indices of triangles; -1 for misses."""
        hit = hits.hit
        return np.where(hit, self.triangles[np.where(hit, hits.primID, 0)], -1)

    def nearest(self, points: Doubles) -> Integers:
        """Returns the closest triangle of each point, or -1 if there is none."""
        if not self.scene:
            return np.full(len(points), -1)
        return self.triangles_of(self.scene.closest_points(points)[1])

    def first(self, origins: Doubles, directions: Doubles) -> Tuple[Integers, Doubles]:
        """Returns the triangle, or -1, and the distance of each ray's first hit."""
        if not self.scene:
            return np.full(len(origins), -1), np.full(len(origins), np.inf)
        hits = self.scene.intersect(origins, directions)
        return self.triangles_of(hits), hits.t.astype(np.float64)

    def any(self, origins: Doubles, directions: Doubles) -> Flags:
        """Returns True for rays that hit."""
        return self.scene.occluded(origins, directions) if self.scene else np.zeros(len(origins), bool)

    def all(self, origins: Doubles, directions: Doubles) -> Tuple[Integers, Integers, Doubles]:
        """Returns rays, triangles and distances of all hits, ordered by ray, then by distance.

        Hits of a ray at the same distance as the one before, or at the next float of 32 bits, are left out.
        """
        if not self.scene:
            return np.zeros(0, int), np.zeros(0, int), np.zeros(0)
        hits, rays = self.scene.all_hits(origins, directions)
        same = np.zeros(len(rays), bool)
        same[1:] = (rays[1:] == rays[:-1]) & (hits.t[1:] <= np.nextafter(hits.t[:-1], np.float32(np.inf)))
        return rays[~same], self.triangles_of(hits)[~same], hits.t[~same].astype(np.float64)

    def contains(self, points: Doubles) -> Flags:
        """Returns True for points inside of the mesh."""
        return self.scene.contains(points) if self.scene else np.zeros(len(points), bool)


class Placement:
    """Between the units of a mesh and those of its scene, in which the mesh's box begins at 0."""

    # Around the box, as a part of its diagonal. Floats there are as precise as inside, and of rays almost in the plane
    # of a triangle more hit than if they started at the box itself.
    MARGIN = 0.25
    ROUNDING = 1e-6  # of vertices and rays in the scene, as a part of the diagonal; at most a few times 2**-24

    def __init__(self, corners: Doubles, scale_to_box: bool) -> None:
        self.origin, size = np.zeros(3), np.zeros(3)
        if len(corners):
            self.origin = corners.min(axis=0)
            size = corners.max(axis=0) - self.origin
        diagonal = float(np.linalg.norm(size))
        self.scale = 100 / diagonal if scale_to_box and diagonal > 0 else 1.0
        self.rounding = self.ROUNDING * diagonal * self.scale
        margin = self.MARGIN * diagonal
        self.lower, self.upper = np.full(3, -margin) * self.scale, (size + margin) * self.scale

    def to_scene(self, points: Doubles) -> Doubles:
        return (points - self.origin) * self.scale

    def to_mesh(self, points: Doubles) -> Doubles:
        return points / self.scale + self.origin

    def encloses(self, points: Doubles) -> Flags:
        """True for points, in the scene, in its box with the margin."""
        inside: Flags = ((points >= self.lower) & (points <= self.upper)).all(axis=1)
        return inside

    def entries(self, origins: Doubles, directions: Doubles) -> Doubles:
        """Distances along the rays, in the scene, to its box with a margin: 0 from inside, infinity for misses."""
        parallel = np.abs(directions) < 1e-300
        between = (origins >= self.lower) & (origins <= self.upper)
        with np.errstate(all="ignore"):
            first = (self.lower - origins) / directions
            last = (self.upper - origins) / directions
        first, last = np.minimum(first, last), np.maximum(first, last)
        first = np.where(parallel, np.where(between, -np.inf, np.inf), first)
        last = np.where(parallel, np.where(between, np.inf, -np.inf), last)
        entry: Doubles = np.maximum(first.max(axis=1), 0)
        return np.where(entry <= last.min(axis=1), entry, np.inf)


def unit(vectors: Doubles) -> Doubles:
    """Directions of length 1; NaN for vectors of length 0 and vectors that are not finite."""
    with np.errstate(all="ignore"):
        vectors = vectors / np.abs(vectors).max(axis=-1, keepdims=True)  # so that no square under- or overflows
        result: Doubles = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return result


def on_triangles(points: Doubles, corners: Doubles, tolerance: float) -> Flags:
    """True if the point is in the triangle or next to it; False for triangles of no area. corners: (n, 3, 3)."""
    in_box = (points >= corners.min(axis=1) - tolerance) & (points <= corners.max(axis=1) + tolerance)
    near: Flags = in_box.all(axis=1)
    following = np.roll(corners, -1, axis=1) - corners
    normals = unit(np.cross(following[:, 0], following[:, 1]))
    for i in range(3):
        outward = unit(np.cross(following[:, i], normals))
        near &= ((points - corners[:, i]) * outward).sum(axis=1) <= tolerance
    return near


def closest_on_triangles(points: Doubles, corners: Doubles) -> Doubles:
    """Returns the closest points of triangles (n, 3, 3) in double precision: of edges, or projections to planes."""

    def of_edge(begin: Doubles, end: Doubles) -> Doubles:
        edge = end - begin
        with np.errstate(all="ignore"):
            at = ((points - begin) * edge).sum(axis=1) / (edge * edge).sum(axis=1)
        nearest: Doubles = begin + np.clip(np.nan_to_num(at), 0, 1)[:, None] * edge
        return nearest

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
    result: Doubles = candidates[nearest, np.arange(len(points))]
    return result


class RayMeshIntersector:
    """The interface of trimesh.ray.ray_pyembree.RayMeshIntersector."""

    def __init__(self, geometry: Any, scale_to_box: bool = True) -> None:
        """geometry: a Trimesh. scale_to_box: scales the mesh to a size of about 100 before tracing."""
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._built: Optional[Tuple[int, CompressedMesh, Placement]] = None

    def _scene(self) -> Tuple[CompressedMesh, Placement]:
        """The compressed mesh and its placement. Built again after a change of the mesh."""
        key = hash(self.mesh)
        if self._built is None or self._built[0] != key:
            vertices = np.asarray(self.mesh.vertices, dtype=np.float64)
            faces = np.asarray(self.mesh.faces, dtype=np.int64)
            used = np.zeros(len(vertices), bool)
            used[faces] = True
            placement = Placement(vertices[used & np.isfinite(vertices).all(axis=1)], self._scale_to_box)
            placed = np.where(used[:, None], placement.to_scene(vertices), 0)
            self._built = key, CompressedMesh(placed, faces), placement
        return self._built[1:]

    def _prepare(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> Tuple[CompressedMesh, Placement, Integers, Doubles, Doubles]:
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

    def memory_bytes(self) -> int:
        """Memory of the triangles and their tree."""
        return self._scene()[0].memory_bytes()

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Integers:
        """Returns (n,) int64: the first triangle that each ray hits, or -1."""
        scene, _, rays, origins, directions = self._prepare(ray_origins, ray_directions)
        first = np.full(len(np.asarray(ray_origins)), -1)
        first[rays] = scene.first(origins, directions)[0]
        return first

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Flags:
        """Returns (n,) bool: True if the ray hits the mesh."""
        scene, _, rays, origins, directions = self._prepare(ray_origins, ray_directions)
        hit = np.zeros(len(np.asarray(ray_origins)), bool)
        hit[rays] = scene.any(origins, directions)
        return hit

    def _hits(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, max_hits: Optional[int], with_locations: bool
    ) -> Tuple[NDArray[Any], ...]:
        """Returns triangles (m,), rays (m,) and if requested locations (m, 3), ordered by ray, then by distance."""
        scene, placement, rays, origins, directions = self._prepare(ray_origins, ray_directions)
        if max_hits == 1:
            triangles, distances = scene.first(origins, directions)
            of_hits = np.nonzero(triangles != -1)[0]
            triangles, distances = triangles[of_hits], distances[of_hits]
        else:
            of_hits, triangles, distances = scene.all(origins, directions)
        if max_hits is not None:
            number = np.arange(len(of_hits)) - np.searchsorted(of_hits, of_hits)  # along its ray, from 0
            near = number < max_hits
            of_hits, triangles, distances = of_hits[near], triangles[near], distances[near]
        if not with_locations:
            return triangles, rays[of_hits]
        locations = self._locations(placement, triangles, origins[of_hits], directions[of_hits], distances)
        return triangles, rays[of_hits], locations

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: Optional[int] = None,
        return_locations: bool = False,
    ) -> Tuple[NDArray[Any], ...]:
        """Returns the triangles and the rays of all hits, and if requested their locations.

        max_hits: most hits per ray, the closest ones; None for all. Hits of one ray at the same distance, or at
        adjacent floats of 32 bits, for example at an edge, count as one.
        """
        return self._hits(ray_origins, ray_directions, max_hits if multiple_hits else 1, return_locations)

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True
    ) -> Tuple[Doubles, Integers, Integers]:
        """Returns locations (m, 3), rays (m,) and triangles (m,) of all hits."""
        triangles, rays, locations = self._hits(ray_origins, ray_directions, None if multiple_hits else 1, True)
        return locations, rays, triangles

    def contains_points(self, points: ArrayLike) -> Flags:
        """Returns (n,) bool: True if the point is inside of the mesh, which must be closed.

        Points are rounded to floats of 32 bits in the scene.
        """
        scene, placement = self._scene()
        placed = placement.to_scene(np.asarray(points, dtype=np.float64).reshape(-1, 3))
        inside = placement.encloses(placed)
        inside[inside] = scene.contains(placed[inside])
        return inside

    def closest_points(self, points: ArrayLike) -> Tuple[Doubles, Doubles, Integers]:
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

    def _locations(
        self, placement: Placement, triangles: Integers, origins: Doubles, directions: Doubles, distances: Doubles
    ) -> Doubles:
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
        traced = origins + distances[:, None] * directions
        return placement.to_mesh(np.where(exact[:, None], points, traced))

    def __getstate__(self) -> Dict[str, Any]:
        return dict(self.__dict__, _built=None)


class ProximityQuery:
    """The interface of trimesh.proximity.ProximityQuery, for points on the surface."""

    def __init__(self, mesh: Any, rays: Optional[RayMeshIntersector] = None) -> None:
        """mesh: a Trimesh. rays: its RayMeshIntersector, whose compressed mesh is used. None makes one."""
        self._rays = rays or RayMeshIntersector(mesh)

    def on_surface(self, points: ArrayLike) -> Tuple[Doubles, Doubles, Integers]:
        """Returns the closest points of the mesh (n, 3), their distances (n,) and triangles (n,) int64."""
        return self._rays.closest_points(points)

    def signed_distance(self, points: ArrayLike) -> Doubles:
        """Returns (n,) distances, positive inside of the mesh, which must be closed, negative outside."""
        distances = self._rays.closest_points(points)[1]
        inside = self._rays.contains_points(points)
        return np.where(inside, distances, -distances)
