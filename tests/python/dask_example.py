#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Dask's workers compute the sky-view factors of one process, also if one of them is killed.

dask_example.py EXAMPLE
"""

import importlib
import os
import signal
import subprocess
import sys
import tempfile

import dask
import dask.distributed
import numpy as np

import embree_cbvh as cbvh
from terrains import NATIONAL, hills

SIZE = 16


def load_example():
    """Workers, which are other processes, import it by its name."""
    folder, name = os.path.split(sys.argv[1])
    os.environ["PYTHONPATH"] = os.pathsep.join([folder, os.environ["PYTHONPATH"]])
    sys.path.insert(0, folder)
    return importlib.import_module(os.path.splitext(name)[0])


def main():
    example = load_example()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "hills.cbvh")
        cbvh.terrain(hills(90, 110), 2.0, NATIONAL, path=path)
        terrain = cbvh.Terrain.load(path)
        tiles = list(example.tiles_of(terrain.shape, SIZE))
        expected = [example.sky_view_factors_of_tile(terrain, tile, 1.0) for tile in tiles]
        assert all(np.isfinite(part).all() for part in expected)
        assert 0.05 < np.ptp(np.concatenate([part.ravel() for part in expected]))

        def run(*options):
            """Runs the program."""
            output = os.path.join(folder, "factors.npy")
            subprocess.run([sys.executable, "-B", sys.argv[1], path, output, "--tile", "50", *options], check=True)
            factors = np.load(output)
            for tile, part in zip(tiles, expected):
                assert factors[tile].tobytes() == part.tobytes(), tile

        dask.config.set({"temporary-directory": folder})
        run()
        with dask.distributed.Client(n_workers=3, threads_per_worker=1, dashboard_address=None) as client:
            futures = example.submit(client, path, SIZE, 1.0)
            first = next(iter(dask.distributed.as_completed(futures)))
            killed = client.who_has([first])[first.key][0]
            os.kill(client.run(os.getpid, workers=[killed])[killed], signal.SIGKILL)
            found = client.gather(futures)
            assert killed not in client.scheduler_info()["workers"], "the worker lives"
            run("--scheduler", client.scheduler.address)
        for tile, a, b in zip(tiles, expected, found):
            assert a.tobytes() == b.tobytes(), tile
    print(len(tiles), "tiles are equal,", killed, "was killed")


if __name__ == "__main__":
    main()
