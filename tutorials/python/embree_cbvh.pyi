# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Types of the Python module embree_cbvh. Its docstrings describe arguments and results."""

import os
from typing import Any, Callable, Dict, Iterable, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Path = Union[str, "os.PathLike[str]"]
Progress = Optional[Callable[[str, float], Any]]
Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]
Indices = NDArray[np.uint32]
Flags = NDArray[np.bool_]

__version__: str

class Error(ValueError): ...

class Cage:
    def __init__(
        self,
        vertices: ArrayLike,
        indices: ArrayLike,
        face_vertex_counts: Optional[ArrayLike] = None,
        *,
        uvs: Optional[ArrayLike] = None,
        uv_indices: Optional[ArrayLike] = None,
        crease_edges: ArrayLike = (),
        crease_sharpness: Optional[ArrayLike] = None,
        corner_vertices: ArrayLike = (),
        corner_sharpness: Optional[ArrayLike] = None,
        holes: ArrayLike = (),
        boundary: str = "edge_only",
        name: str = "cage",
    ) -> None: ...
    @staticmethod
    def load(path: Path) -> Cage: ...
    @property
    def name(self) -> str: ...
    @property
    def vertices(self) -> Floats: ...
    @property
    def face_vertex_counts(self) -> Indices: ...
    @property
    def indices(self) -> Indices: ...
    @property
    def uvs(self) -> Floats: ...
    @property
    def uv_indices(self) -> Indices: ...
    @property
    def crease_edges(self) -> Indices: ...
    @property
    def crease_sharpness(self) -> Floats: ...
    @property
    def corner_vertices(self) -> Indices: ...
    @property
    def corner_sharpness(self) -> Floats: ...
    @property
    def holes(self) -> Indices: ...
    @property
    def boundary(self) -> str: ...
    @property
    def bounds(self) -> Floats: ...

class Model:
    def __init__(
        self,
        cage: Cage,
        height: Union[None, Path, ArrayLike] = None,
        amplitude: Optional[float] = None,
        *,
        mid_level: Optional[float] = None,
        channel: str = "",
        repeat: ArrayLike = 1,
        values: str = "heights",
        poses: Optional[ArrayLike] = None,
        wrap: Optional[str] = None,
    ) -> None: ...
    @staticmethod
    def generate(
        name: str,
        amplitude: Optional[float] = None,
        *,
        rough: bool = False,
        mapping: Optional[str] = None,
        count: Optional[int] = None,
        motion: str = "",
        steps: Optional[int] = None,
        map_folder: Optional[Path] = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> Model: ...
    @property
    def cage(self) -> Cage: ...
    @property
    def name(self) -> str: ...
    @property
    def copies(self) -> int: ...
    @property
    def steps(self) -> int: ...
    @property
    def is_displaced(self) -> bool: ...
    def num_quads(self, level: int) -> int: ...
    def tessellate(self, level: int, *, threads: int = 0, progress: Progress = None) -> Tuple[Floats, Indices]: ...

def scene_names() -> List[str]: ...

class Camera:
    def __init__(
        self,
        eye: ArrayLike,
        look_at: ArrayLike,
        up: ArrayLike = (0.0, 1.0, 0.0),
        fov: float = 35.0,
        size: Tuple[int, int] = (1024, 1024),
    ) -> None: ...
    @property
    def eye(self) -> Floats: ...
    @property
    def look_at(self) -> Floats: ...
    @property
    def fov(self) -> float: ...
    @property
    def size(self) -> Tuple[int, int]: ...
    @property
    def pixel_size(self) -> float: ...

class Hits:
    @property
    def hit(self) -> Flags: ...
    @property
    def t(self) -> Floats: ...
    @property
    def u(self) -> Floats: ...
    @property
    def v(self) -> Floats: ...
    @property
    def Ng(self) -> Floats: ...
    @property
    def primID(self) -> Indices: ...
    @property
    def geomID(self) -> Indices: ...
    @property
    def shape(self) -> Tuple[int, ...]: ...

def nearer_hits(a: Hits, b: Hits) -> Hits: ...
def primary_rays(camera: Camera) -> Tuple[Floats, Floats]: ...
def coherent_rays(camera: Camera, count: int = 0) -> Tuple[Floats, Floats]: ...
def bounce_rays(
    hits: Hits,
    origins: ArrayLike,
    directions: ArrayLike,
    *,
    offset: float,
    count: int = 0,
    seed: int = 1,
) -> Tuple[Floats, Floats]: ...

class Geometry:
    @property
    def num_primitives(self) -> int: ...
    @property
    def steps(self) -> int: ...
    @property
    def max_error(self) -> Optional[float]: ...

class Grid(Geometry):
    def __init__(
        self,
        points: ArrayLike,
        *,
        max_error: Optional[float] = None,
        times: Tuple[float, float] = (0.0, 1.0),
    ) -> None: ...
    @staticmethod
    def from_heights(
        heights: ArrayLike,
        cell: ArrayLike = 1.0,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        *,
        max_error: Optional[float] = None,
        times: Tuple[float, float] = (0.0, 1.0),
    ) -> Grid: ...

class Mesh(Geometry):
    def __init__(
        self,
        vertices: ArrayLike,
        indices: ArrayLike,
        *,
        max_error: Optional[float] = None,
        times: Tuple[float, float] = (0.0, 1.0),
    ) -> None: ...
    @staticmethod
    def load(path: Path, *, max_error: Optional[float] = None) -> Mesh: ...

def read_mesh(path: Path) -> Dict[str, NDArray[Any]]: ...

class Subdivision(Geometry):
    def __init__(self, model: Union[Model, Cage], level: int = 6, *, max_error: Optional[float] = None) -> None: ...

class Scene:
    def __init__(
        self,
        geometries: Iterable[Union[Geometry, Model, Cage]],
        representation: str = "ctile",
        *,
        threads: int = 0,
        isa: str = "",
        progress: Progress = None,
    ) -> None: ...
    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = ...,
        *,
        time: ArrayLike = 0.0,
        threads: int = 0,
    ) -> Hits: ...
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = ...,
        *,
        time: ArrayLike = 0.0,
        threads: int = 0,
    ) -> Flags: ...
    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = ...,
        *,
        time: ArrayLike = 0.0,
        max_hits: Optional[int] = None,
        threads: int = 0,
    ) -> Tuple[Hits, NDArray[np.int64]]: ...
    def closest_points(
        self, points: ArrayLike, radius: ArrayLike = ..., *, time: ArrayLike = 0.0, threads: int = 0
    ) -> Tuple[Floats, Hits]: ...
    def distance(
        self, points: ArrayLike, radius: ArrayLike = ..., *, time: ArrayLike = 0.0, threads: int = 0
    ) -> Floats: ...
    def signed_distance(
        self, points: ArrayLike, radius: ArrayLike = ..., *, time: ArrayLike = 0.0, threads: int = 0
    ) -> Floats: ...
    def contains(self, points: ArrayLike, *, time: ArrayLike = 0.0, threads: int = 0) -> Flags: ...
    def trace_seconds(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        query: str = "closest",
        mode: str = "single",
        coherent: bool = False,
        threads: int = 1,
        passes: int = 1,
    ) -> float: ...
    def camera(self, view: str = "full", size: Tuple[int, int] = (1024, 1024)) -> Camera: ...
    def statistics(self) -> Dict[str, Any]: ...
    def triangles(self, hits: Hits, *, time: float = 0.0) -> Floats: ...
    def stored_mesh(self, *, time: float = 0.0) -> Dict[str, NDArray[Any]]: ...
    def save(self, path: Path) -> None: ...
    @property
    def geometries(self) -> int: ...
    @property
    def bounds(self) -> Floats: ...

class ModelScene(Scene):
    def compare(self, hits: Hits, reference: Hits, pixel_size: float) -> Dict[str, Any]: ...
    def true_errors(
        self,
        hits: Hits,
        origins: ArrayLike,
        directions: ArrayLike,
        pixel_size: float,
        *,
        count: int = 2000,
        seed: int = 1,
        threads: int = 0,
        progress: Progress = None,
    ) -> Dict[str, Any]: ...
    @property
    def model(self) -> Model: ...
    @property
    def representation(self) -> str: ...
    @property
    def level(self) -> int: ...

class LoadedScene(Scene):
    @property
    def quads(self) -> int: ...
    @property
    def open_seconds(self) -> float: ...

def build(
    model: Union[Model, Cage],
    representation: str = "ctile",
    level: int = 6,
    *,
    frame_level: Union[None, int, str] = None,
    max_error: Optional[float] = None,
    max_pixel_error: float = 0.0,
    camera: Optional[Camera] = None,
    threads: int = 0,
    isa: str = "",
    device: str = "cpu",
    progress: Progress = None,
) -> ModelScene: ...
def pixel_errors(hits: Hits, reference: Hits, pixel_size: float) -> Floats: ...
def load(path: Path, *, representation: str = "cvert", threads: int = 0) -> LoadedScene: ...

class TerrainHits:
    @property
    def hit(self) -> Flags: ...
    @property
    def t(self) -> Doubles: ...
    @property
    def position(self) -> Doubles: ...
    @property
    def normal(self) -> Floats: ...
    @property
    def row(self) -> Doubles: ...
    @property
    def column(self) -> Doubles: ...
    @property
    def shape(self) -> Tuple[int, ...]: ...

class Terrain:
    @staticmethod
    def load(path: Path, *, representation: str = "cvert", threads: int = 0) -> Terrain: ...
    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = ...,
        *,
        threads: int = 0,
    ) -> TerrainHits: ...
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        tnear: ArrayLike = 0.0,
        tfar: ArrayLike = ...,
        *,
        threads: int = 0,
    ) -> Flags: ...
    def horizon(
        self, points: ArrayLike, azimuths: ArrayLike, *, accuracy: float = 0.25, threads: int = 0
    ) -> Floats: ...
    def sky_view_factor(
        self, points: ArrayLike, azimuths: int = 16, *, accuracy: float = 0.25, threads: int = 0
    ) -> Floats: ...
    def viewshed(self, observer: ArrayLike, points: ArrayLike, *, threads: int = 0) -> Flags: ...
    def save(self, path: Path) -> None: ...
    def statistics(self) -> Dict[str, Any]: ...
    @property
    def shape(self) -> Tuple[int, int]: ...
    @property
    def cell(self) -> Tuple[float, float]: ...
    @property
    def origin(self) -> Tuple[float, float, float]: ...
    @property
    def max_error(self) -> float: ...
    @property
    def bounds(self) -> Doubles: ...

def terrain(
    heights: Any,
    cell: ArrayLike = 1.0,
    origin: ArrayLike = (0.0, 0.0),
    *,
    max_error: Optional[float] = None,
    nodata: Optional[float] = None,
    representation: Optional[str] = None,
    path: Optional[Path] = None,
    threads: int = 0,
    progress: Progress = None,
) -> Terrain: ...
def read_raster(
    path: Path, *, channel: str = "", encoding: str = "", nodata: Optional[float] = None, threads: int = 0
) -> Dict[str, Any]: ...
def write_raster(
    path: Path,
    values: ArrayLike,
    like: Union[Terrain, Path],
    *,
    row: int = 0,
    column: int = 0,
    crs: Optional[Path] = None,
) -> None: ...
