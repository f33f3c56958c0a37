# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Hits of rays on all triangles, in double precision."""

import numpy as np


def grid_triangles(points):
    """(n, 3, 3) corners of the triangles of a grid of (rows, columns, 3) points, two per quad."""
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    return np.stack([np.stack([a, b, c], -2), np.stack([c, b, d], -2)], 2).reshape(-1, 3, 3)


def closest_hits(origins, directions, corners, slack=0.0):
    """Distances of the closest hits, inf for a miss, and the triangles, -1 for a miss.

    slack: by which triangles are larger, as a part of their size.
    """
    origins, directions, corners = (np.asarray(a, np.float64) for a in (origins, directions, corners))
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(e1, e2)
    distances, triangles = np.full(len(origins), np.inf), np.full(len(origins), -1)
    for i, (o, d) in enumerate(zip(origins, directions)):
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / -(normal @ d)
            to = o - a
            t = np.einsum("ij,ij->i", to, normal) * scale
            across = np.cross(to, d)
            u, v = np.einsum("ij,ij->i", e2, across) * scale, np.einsum("ij,ij->i", e1, across) * -scale
            inside = (u >= -slack) & (v >= -slack) & (u + v <= 1 + slack) & (t >= 0)
        if inside.any():
            triangles[i] = np.where(inside, t, np.inf).argmin()
            distances[i] = t[triangles[i]]
    return distances, triangles
