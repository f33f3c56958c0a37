# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Distances from a point to triangles, in double precision."""

import numpy as np


def distances_to_triangles(point, corners):
    """Of (n, 3, 3) triangles: the least distance of edges and, where the projection is inside, of the plane."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def of_edge(begin, end):
        edge = end - begin
        at = np.einsum("ij,ij->i", point - begin, edge) / np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-300)
        return np.linalg.norm(begin + np.clip(at, 0, 1)[:, None] * edge - point, axis=1)

    normal = np.cross(b - a, c - a)
    area = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    inside = np.ones(len(a), bool)
    for begin, end in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(end - begin, point - begin), normal) >= 0
    height = np.abs(np.einsum("ij,ij->i", point - a, normal)) / np.sqrt(area)
    edges = np.minimum(np.minimum(of_edge(a, b), of_edge(b, c)), of_edge(c, a))
    return np.where(inside, np.minimum(height, edges), edges)
