#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Uses the module in a virtual environment, for wheel.py.

    wheel_in_use.py PACKAGE-FOLDER VERSION [before|after LIBRARY...]

Loads another Embree, if the machine has it, before or after the module, and uses it afterwards.
"""

import ctypes
import pathlib
import struct
import sys
import zlib

ORDER, OTHERS = "".join(sys.argv[3:4]), {}


def load_others():
    """The functions of OTHERS are global, as in a renderer with an embedded Python."""
    for name in sys.argv[4:]:
        try:
            OTHERS[name] = ctypes.CDLL(name, ctypes.RTLD_GLOBAL)
            print(f"{name} is loaded {ORDER} the module")
        except OSError:
            pass


if ORDER == "before":  # the dynamic linker then finds their functions first
    load_others()

import numpy as np


def version_of(embree):
    embree.rtcNewDevice.argtypes, embree.rtcNewDevice.restype = [ctypes.c_char_p], ctypes.c_void_p
    embree.rtcGetDeviceProperty.argtypes = [ctypes.c_void_p, ctypes.c_int]
    embree.rtcGetDeviceProperty.restype = ctypes.c_ssize_t
    embree.rtcReleaseDevice.argtypes, embree.rtcReleaseDevice.restype = [ctypes.c_void_p], None
    device = embree.rtcNewDevice(None)
    version = embree.rtcGetDeviceProperty(device, 0)  # RTC_DEVICE_PROPERTY_VERSION, such as 40303
    embree.rtcReleaseDevice(device)
    return version


def loaded_libraries():
    with open("/proc/self/maps", encoding="utf-8") as maps:
        return {pathlib.Path(line.split()[-1]) for line in maps if ".so" in line}


import embree_cbvh as cbvh
from embree_cbvh.trimesh_rays import RayMeshIntersector

if ORDER == "after":
    load_others()


class Grid:
    """16 x 16 squares of two triangles each, in the unit square."""

    vertices = np.array([(x / 16, y / 16, 0) for y in range(17) for x in range(17)])
    corners = np.array([(i, i + 1, i + 17, i + 18) for i in (y * 17 + x for y in range(16) for x in range(16))])
    faces = corners[:, [[0, 1, 3], [0, 3, 2]]].reshape(-1, 3)


def write_tiff(path, texels):
    """A 16-bit gray image in one compressed strip."""
    height, width = texels.shape
    data = zlib.compress(texels.astype("<u2").tobytes())
    # width, height, bits, compression (Deflate), black is zero, offset, samples, rows per strip, bytes
    tags = {256: width, 257: height, 258: 16, 259: 8, 262: 1, 273: 8, 277: 1, 278: height, 279: len(data)}
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
    directory = struct.pack("<H", len(tags)) + entries + struct.pack("<I", 0)
    path.write_bytes(b"II" + struct.pack("<HI", 42, 8 + len(data)) + data + directory)


def main():
    package, version = pathlib.Path(sys.argv[1]), sys.argv[2]
    assert pathlib.Path(cbvh.__file__).parent == package, cbvh.__file__
    assert cbvh.__version__ == version, cbvh.__version__
    assert cbvh.Cage.__module__ == cbvh.__name__ == "embree_cbvh"

    # a displaced sheet of 2 x 2 faces
    x, y = np.meshgrid(np.linspace(0, 1, 3), np.linspace(0, 1, 3))
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    faces = [(i, i + 1, i + 4, i + 3) for i in (0, 1, 3, 4)]
    cage = cbvh.Cage(vertices, faces, uvs=vertices[:, :2])
    s, t = np.meshgrid(np.linspace(0, 6, 64), np.linspace(0, 6, 64))
    heights = (0.5 + 0.25 * np.sin(s) * np.cos(t)).astype(np.float32)
    texels = np.round(heights * 65535)
    write_tiff(pathlib.Path("heights.tif"), texels)
    models = cbvh.Model(cage, texels / 65535, amplitude=0.1), cbvh.Model(cage, "heights.tif", amplitude=0.1)

    scenes = [cbvh.build(model, "cvert", level=5) for model in models]
    assert scenes[0].statistics()["compression"]["quads"] == 4 * 4**5
    camera = scenes[0].camera("full", (64, 48))
    rays = cbvh.primary_rays(camera)
    hits, same = (scene.intersect(*rays) for scene in scenes)
    assert hits.hit.sum() > 500
    np.testing.assert_allclose(hits.t[hits.hit & same.hit], same.t[hits.hit & same.hit], atol=1e-4)
    grid = cbvh.build(models[0], "grid", level=5).intersect(*rays)
    assert scenes[0].compare(hits, grid, camera.pixel_size)["max_pixels"] < 1

    # a picture: the angle between ray and normal
    lengths = np.where(hits.hit, np.linalg.norm(hits.Ng, axis=-1), 1)
    picture = np.where(hits.hit, np.abs((hits.Ng * rays[1]).sum(axis=-1)) / lengths, 0)
    assert picture.shape == (48, 64) and len(np.unique(picture)) > 100

    scenes[0].save("sheet.cbvh")
    loaded = cbvh.load("sheet.cbvh").intersect(*rays)
    for field in ("t", "u", "v", "Ng", "primID", "hit"):
        assert getattr(hits, field).tobytes() == getattr(loaded, field).tobytes(), field

    # the ray engine for trimesh
    below = np.array([[0.9, 0.1, -1], [0.1, 0.9, -1], [17, 0.2, -1]]) / [16, 16, 1]
    assert RayMeshIntersector(Grid()).intersects_first(below, [[0, 0, 1]] * 3).tolist() == [0, 1, -1]

    for name, embree in OTHERS.items():
        assert f"libembree{version_of(embree) // 10000}.so" in name, f"{name} answers as {version_of(embree)}"

    files = loaded_libraries()
    ours = {file for file in files if package in file.parents}
    assert any(file.name.startswith("libembree_cbvh-") for file in ours), ours
    if not ORDER:
        names = "OpenImageIO OpenEXR Imath Iex IlmThread tbb tiff jpeg png osd gomp boost embree".split()
        others = {file for file in files - ours if file.name.startswith(tuple("lib" + name for name in names))}
        assert not others, f"loaded from elsewhere: {others}"
    print(len(ours), "libraries of the wheel are loaded,", int(hits.hit.sum()), "rays hit")


if __name__ == "__main__":
    main()
