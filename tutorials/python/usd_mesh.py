#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Reads the subdivision surfaces of a USD stage, and saves them compressed. Requires the package usd-core.

    usd_mesh.py STAGE OUTPUT.cbvh [--level 6]

cage_of() converts a UsdGeom.Mesh with its scheme, creases, corners, holes, boundary rule, texture coordinates and
transformation, for your own scene:

    cbvh.Model(cage_of(mesh, Usd.TimeCode.EarliestTime()), "height.exr", amplitude=0.01)
"""

import argparse
import warnings
from typing import Any, Iterator, Optional, Tuple

import embree_cbvh as cbvh
import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

Array = NDArray[Any]

BOUNDARIES = {"none": "none", "edgeOnly": "edge_only", "edgeAndCorner": "edge_and_corner"}


def array_of(attribute: Any, time: Any, dtype: str, width: int = 0) -> Array:
    """The value of an attribute, (n,) or (n, width), empty if it has none."""
    value = attribute.Get(time)
    array = np.array([] if value is None else value, dtype=dtype)
    return array.reshape(-1, width) if width else array


def creases_of(mesh: Any, time: Any) -> Tuple[Array, Array]:
    """Edges (c, 2) and their sharpness (c,). A crease of n vertices has n - 1 edges, with one sharpness or one each."""
    vertices = array_of(mesh.GetCreaseIndicesAttr(), time, "i8")
    lengths = array_of(mesh.GetCreaseLengthsAttr(), time, "i8")
    sharpness = array_of(mesh.GetCreaseSharpnessesAttr(), time, "f4")
    if lengths.sum() != len(vertices) or (lengths < 2).any():
        raise ValueError(f"{mesh.GetPath()}: creaseLengths do not fit {len(vertices)} creaseIndices")
    if len(sharpness) == len(lengths):
        sharpness = np.repeat(sharpness, lengths - 1)
    elif len(sharpness) != (lengths - 1).sum():
        raise ValueError(f"{mesh.GetPath()}: {len(sharpness)} creaseSharpnesses fit neither creases nor their edges")
    is_first = np.ones(len(vertices), bool)
    is_first[np.cumsum(lengths) - 1] = False  # the last vertex of a crease begins no edge
    begins = np.nonzero(is_first)[0]
    return np.stack([vertices[begins], vertices[begins + 1]], -1), sharpness


def uvs_of(mesh: Any, time: Any, name: str, indices: Array) -> Tuple[Optional[Array], Optional[Array]]:
    """Texture coordinates (m, 2), and their indices, parallel to those of vertices; None if the mesh has none."""
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar(name)
    if not primvar.HasValue():
        return None, None
    uvs = array_of(primvar, time, "f4", 2)
    interpolation = primvar.GetInterpolation()
    if interpolation in ("vertex", "varying"):
        places = indices
    elif interpolation == "faceVarying":
        places = np.arange(len(indices))
    else:
        raise ValueError(f"{mesh.GetPath()}: {name} is {interpolation}: expected faceVarying, vertex or varying")
    rule = mesh.GetFaceVaryingLinearInterpolationAttr().Get(time)
    if interpolation == "vertex" or (interpolation == "faceVarying" and rule != "all"):
        warnings.warn(f"{mesh.GetPath()}: {name} is smooth in USD, and linear within faces of the cage")
    if primvar.IsIndexed():
        of_places = np.array(primvar.GetIndices(time), "i8")
        if len(of_places) <= places.max(initial=-1):
            raise ValueError(f"{mesh.GetPath()}: {name} has {len(of_places)} indices: expected more")
        places = of_places[places]
    return uvs, places


def cage_of(mesh: Any, time: Any, uv_name: str = "st") -> cbvh.Cage:
    """Converts a UsdGeom.Mesh to a cage in world space. Faces are counterclockwise as seen from the front.

    time: a Usd.TimeCode. uv_name: primvar of texture coordinates, which may be missing.

    Raises ValueError that names the mesh if its scheme is not Catmull-Clark, or if arrays do not fit.
    """
    scheme = mesh.GetSubdivisionSchemeAttr().Get(time)
    if scheme != "catmullClark":
        raise ValueError(f"{mesh.GetPath()}: subdivisionScheme is {scheme}: expected catmullClark")
    counts = array_of(mesh.GetFaceVertexCountsAttr(), time, "i8")
    indices = array_of(mesh.GetFaceVertexIndicesAttr(), time, "i8")
    if counts.sum() != len(indices):
        raise ValueError(f"{mesh.GetPath()}: faceVertexCounts add up to {counts.sum()} of {len(indices)} indices")
    if (counts == 3).any() and mesh.GetTriangleSubdivisionRuleAttr().Get(time) == "smooth":
        raise ValueError(f"{mesh.GetPath()}: triangleSubdivisionRule is smooth: expected catmullClark")
    uvs, uv_indices = uvs_of(mesh, time, uv_name, indices)
    crease_edges, crease_sharpness = creases_of(mesh, time)

    matrix = np.array(mesh.ComputeLocalToWorldTransform(time), "f8")  # of row vectors
    points = array_of(mesh.GetPointsAttr(), time, "f8", 3) @ matrix[:3, :3] + matrix[3, :3]
    is_mirrored = np.linalg.det(matrix[:3, :3]) < 0
    if is_mirrored != (mesh.GetOrientationAttr().Get(time) == "leftHanded"):
        ends = np.cumsum(counts)
        corners = np.repeat(2 * ends - counts - 1, counts) - np.arange(len(indices))  # of each face in reverse
        indices = indices[corners]
        uv_indices = None if uv_indices is None else uv_indices[corners]
    try:
        return cbvh.Cage(
            points,
            indices,
            counts,
            uvs=uvs,
            uv_indices=uv_indices,
            crease_edges=crease_edges,
            crease_sharpness=crease_sharpness,
            corner_vertices=array_of(mesh.GetCornerIndicesAttr(), time, "i8"),
            corner_sharpness=array_of(mesh.GetCornerSharpnessesAttr(), time, "f4"),
            holes=array_of(mesh.GetHoleIndicesAttr(), time, "i8"),
            boundary=BOUNDARIES[mesh.GetInterpolateBoundaryAttr().Get(time)],
            name=str(mesh.GetPath()),
        )
    except ValueError as error:
        raise ValueError(f"{mesh.GetPath()}: {error}") from error


def meshes_of(stage: Any, time: Any) -> Iterator[Any]:
    """Visible meshes for final pictures, also in instances. Warns of point instancers, whose instances are left out."""
    prims = iter(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()))
    for prim in prims:
        imageable = UsdGeom.Imageable(prim)
        if prim.IsA(UsdGeom.PointInstancer):
            warnings.warn(f"left out: instances of {prim.GetPath()}")
            prims.PruneChildren()
        elif (
            prim.IsA(UsdGeom.Mesh)
            and imageable.ComputeVisibility(time) != "invisible"
            and imageable.ComputePurpose() in ("default", "render")
        ):
            yield UsdGeom.Mesh(prim)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage")
    parser.add_argument("output")
    parser.add_argument("--level", type=int, default=6, help="a face has 4**level quads")
    options = parser.parse_args()
    time = Usd.TimeCode.EarliestTime()
    stage = Usd.Stage.Open(options.stage)  # prims live as long as their stage
    cages = []
    for mesh in meshes_of(stage, time):
        try:
            cages.append(cage_of(mesh, time))
        except ValueError as error:
            warnings.warn(f"left out: {error}")
    scene = cbvh.Scene([cbvh.Subdivision(cage, options.level) for cage in cages])
    scene.save(options.output)
    print(scene)


if __name__ == "__main__":
    main()
