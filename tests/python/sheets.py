# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Models for the tests of the Python module."""

import numpy as np

import embree_cbvh as cbvh

REPRESENTATIONS = ("naive", "naive-compact", "grid", "cgrid", "cvoxel", "cleaf", "cleaf-only", "cvert", "ctile")


def sheet_arrays(n=5):
    """Vertices and faces of n x n quads with edges of 1/n on the unit square in z = 0, row by row, counterclockwise."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    vertices = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(n))
    corner = (j * (n + 1) + i).ravel()
    return vertices, np.stack([corner, corner + 1, corner + n + 2, corner + n + 1], -1)


def sheet(n=5, **options):
    vertices, faces = sheet_arrays(n)
    return cbvh.Cage(vertices, faces, uvs=vertices[:, :2], name="sheet", **options)


def bumpy_model(n=5):
    """The sheet with different heights everywhere."""
    y, x = np.mgrid[0:64, 0:64] / 63.0
    return cbvh.Model(sheet(n), 0.5 + 0.3 * np.sin(9 * x) * np.cos(7 * y), amplitude=0.1)


def rays_from_above(n=24, lower=0.3, upper=0.7):
    """(n, n, 3) origins at z = 1 above a part of the sheet that borders do not affect, and directions down. No ray
    hits an edge of a triangle, where NAIVE may miss."""
    x, y = np.meshgrid(np.linspace(lower, upper, n) + 0.0013, np.linspace(lower, upper, n) + 0.0007)
    origins = np.stack([x, y, np.ones_like(x)], -1).astype(np.float32)
    return origins, np.broadcast_to(np.array([0, 0, -1], np.float32), origins.shape)
