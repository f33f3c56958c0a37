#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Computes sky-view factors of a terrain on several processes or machines with Dask.

    dask_horizons.py TERRAIN OUTPUT.npy [--scheduler ADDRESS] [--tile 256] [--above 1]

TERRAIN is a file of Terrain.save or of terrain(path=...), which all workers can open. Each worker maps it once, and the
system shares its pages among the processes of a machine. Workers need no halo: a ray reaches the whole terrain, and
only what rays reach is read. Without --scheduler, the script starts a worker per core of this machine.
"""

import argparse
import os
from typing import Iterator, List, Tuple

import dask.distributed
import embree_cbvh as cbvh
import numpy as np
from numpy.typing import NDArray

Tile = Tuple[slice, slice]  # rows and columns


def tiles_of(shape: Tuple[int, int], size: int) -> Iterator[Tile]:
    for row in range(0, shape[0], size):
        for column in range(0, shape[1], size):
            yield slice(row, min(row + size, shape[0])), slice(column, min(column + size, shape[1]))


def open_terrain(path: str) -> cbvh.Terrain:
    return cbvh.Terrain.load(path)


def points_above(terrain: cbvh.Terrain, tile: Tile, above: float) -> NDArray[np.float64]:
    """Positions above samples, (rows, columns, 3); NaN where samples are missing."""
    row, column = np.meshgrid(*(np.arange(part.start, part.stop) for part in tile), indexing="ij")
    # By rounding, a ray exactly at the border of the raster may miss it: these rays start a little inside.
    row = np.clip(row, 1e-3, terrain.shape[0] - 1 - 1e-3)
    column = np.clip(column, 1e-3, terrain.shape[1] - 1 - 1e-3)
    origins = np.empty((*row.shape, 3))
    origins[..., 0] = terrain.origin[0] + column * terrain.cell[0]
    origins[..., 1] = terrain.origin[1] + row * terrain.cell[1]
    origins[..., 2] = terrain.bounds[1, 2] + 1
    return terrain.intersect(origins, [0, 0, -1], threads=1).position + [0, 0, above]


def sky_view_factors_of_tile(terrain: cbvh.Terrain, tile: Tile, above: float) -> NDArray[np.float32]:
    points = points_above(terrain, tile, above)
    found = np.isfinite(points).all(axis=-1)
    factors = np.full(found.shape, np.nan, np.float32)
    factors[found] = terrain.sky_view_factor(points[found], threads=1)  # a worker has one core
    return factors


def submit(client: dask.distributed.Client, path: str, size: int, above: float) -> List[dask.distributed.Future]:
    """Returns a future for each of tiles_of(). Tiles of a worker that dies are computed by others."""
    terrain = client.submit(open_terrain, os.path.abspath(path))  # other workers receive its path
    tiles = tiles_of(cbvh.Terrain.load(path).shape, size)
    return [client.submit(sky_view_factors_of_tile, terrain, tile, above) for tile in tiles]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("terrain")
    parser.add_argument("output")
    parser.add_argument("--scheduler", help="address of a running scheduler, such as tcp://host:8786")
    parser.add_argument("--tile", type=int, default=256, help="samples along a side of a tile")
    parser.add_argument("--above", type=float, default=1.0, help="height above the terrain from which the sky is seen")
    options = parser.parse_args()
    shape = cbvh.Terrain.load(options.terrain).shape
    factors = np.empty(shape, np.float32)
    local = {} if options.scheduler else {"threads_per_worker": 1, "dashboard_address": None}
    with dask.distributed.Client(options.scheduler, **local) as client:
        futures = submit(client, options.terrain, options.tile, options.above)
        for tile, future in zip(tiles_of(shape, options.tile), futures):
            factors[tile] = future.result()
    np.save(options.output, factors)


if __name__ == "__main__":
    main()
