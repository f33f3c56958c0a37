#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Rasters are read from and written to GeoTIFF files at their place on the Earth."""

import json
import os
import shutil
import struct
import subprocess
import tempfile
import unittest

import numpy as np

import embree_cbvh as cbvh
from terrains import NATIONAL, hills

AREA, POINT = 1, 2
TYPES = {"u1": (1, 1), "i2": (2, 2), "f4": (4, 3), "f8": (8, 3)}  # bytes and SampleFormat


def geo_keys(raster_type):
    """A projected coordinate system of EPSG, in which pixels are areas or points."""
    return [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, raster_type, 3072, 0, 1, 25832]


def write_tiff(path, samples, doubles=(), texts=(), keys=(), big_endian=False):
    """An uncompressed TIFF. doubles, texts: (tag, value)."""
    order = ">" if big_endian else "<"
    bits, kind = TYPES[samples.dtype.str[1:]]
    data = samples.astype(samples.dtype.newbyteorder(order)).tobytes()
    rows, columns = samples.shape
    entries = [(256, 4, [columns]), (257, 4, [rows]), (258, 3, [8 * bits]), (259, 3, [1]), (262, 3, [1])]
    entries += [(273, 4, [8]), (277, 3, [1]), (278, 4, [rows]), (279, 4, [len(data)]), (339, 3, [kind])]
    entries += [(tag, 12, value) for tag, value in doubles] + ([(34735, 3, keys)] if len(keys) else [])
    entries += [(tag, 2, list(text.encode() + b"\0")) for tag, text in texts]
    letters = {2: "B", 3: "H", 4: "I", 12: "d"}
    body, end = data + b"\0" * (-len(data) % 2), b""
    directory = struct.pack(order + "H", len(entries))
    for tag, form, values in sorted(entries):
        packed = struct.pack(f"{order}{len(values)}{letters[form]}", *values)
        if len(packed) > 4:
            body += b"\0" * (len(body) % 2)
            packed, body = struct.pack(order + "I", 8 + len(body)), body + packed
        directory += struct.pack(order + "HHI", tag, form, len(values)) + packed.ljust(4, b"\0")
    body += b"\0" * (len(body) % 2)
    with open(path, "wb") as file:
        file.write((b"MM" if big_endian else b"II") + struct.pack(order + "HI", 42, 8 + len(body)))
        file.write(body + directory + struct.pack(order + "I", 0) + end)


def gdal(path):
    """What GDAL says of a file."""
    return json.loads(subprocess.run(["gdalinfo", "-json", path], check=True, stdout=subprocess.PIPE).stdout)


class Rasters(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.files = 0

    def path(self):
        self.files += 1
        return os.path.join(self.folder.name, f"{self.files}.tif")

    def national(self, samples, raster_type=AREA, **options):
        """A file of cells of 2 m; tie points refer to corners of areas, and to points."""
        path = self.path()
        half = 1 if raster_type == AREA else 0
        tie = [0, 0, 0, NATIONAL[0] - half, NATIONAL[1] + half, 0]
        write_tiff(path, samples, [(33550, [2, 2, 0]), (33922, tie)], keys=geo_keys(raster_type), **options)
        return path

    def test_files_are_read_at_their_place(self):
        heights = hills(30, 40).astype(np.float32)
        for raster_type in (AREA, POINT):
            for big_endian in (False, True):
                path = self.national(heights, raster_type, texts=[(42113, "-9999")], big_endian=big_endian)
                read = cbvh.read_raster(path, threads=1)
                np.testing.assert_array_equal(read["heights"], heights)
                self.assertEqual(read["heights"].dtype, np.float32)
                self.assertEqual(read["cell"], (2, -2))
                self.assertEqual(read["origin"], NATIONAL)
        terrain = cbvh.terrain(**read, max_error=0)
        hit = terrain.intersect([NATIONAL[0] + 2 * 7, NATIONAL[1] - 2 * 5, 999], [0, 0, -1])
        self.assertAlmostEqual(float(hit.position[2]), heights[5, 7], places=3)

    def test_scale_offset_and_missing_samples_of_gdal_are_applied(self):
        samples = np.round(10 * hills(30, 40)).astype(np.int16)
        samples[3, 4], samples[5, 6] = -32768, 77
        item = '<Item name="X" sample="{}" role="{}">{}</Item>'
        items = [item.format(0, "scale", 0.25), item.format(0, "offset", -40), item.format(1, "scale", 9)]
        texts = [(42112, f"<GDALMetadata>{''.join(items)}</GDALMetadata>"), (42113, "-32768")]
        expected = (samples * 0.25 - 40).astype(np.float32)
        expected[3, 4] = expected[5, 6] = np.nan
        for big_endian in (False, True):
            path = self.national(samples, texts=texts, big_endian=big_endian)
            np.testing.assert_array_equal(cbvh.read_raster(path, nodata=77)["heights"], expected)
        path = self.national(samples, texts=[(42112, item.format(0, "offset", "deep"))])
        with self.assertRaisesRegex(cbvh.Error, r"\.tif: .*offset 'deep': expected a finite number"):
            cbvh.read_raster(path)

    def test_values_are_written_at_the_place_of_a_terrain(self):
        terrain = cbvh.terrain(hills(30, 40), 2, NATIONAL)
        values = np.arange(1200, dtype=np.float32).reshape(30, 40)
        values[2, 3] = np.nan
        path = self.path()
        cbvh.write_raster(path, values, terrain)
        read = cbvh.read_raster(path)
        np.testing.assert_array_equal(read["heights"], values)
        self.assertEqual((read["cell"], read["origin"]), (terrain.cell, terrain.origin[:2]))
        cbvh.write_raster(self.path(), values[7:20, 5:30:1], terrain, row=7, column=5)
        read = cbvh.read_raster(os.path.join(self.folder.name, "2.tif"))
        np.testing.assert_array_equal(read["heights"], values[7:20, 5:30])
        self.assertEqual(read["origin"], (NATIONAL[0] + 10, NATIONAL[1] - 14))

    def test_rows_may_go_north(self):
        path = self.path()
        cbvh.write_raster(path, np.zeros((5, 6)), cbvh.terrain(np.zeros((5, 6)), (2, 3), (10, 20)))
        read = cbvh.read_raster(path)
        self.assertEqual((read["cell"], read["origin"]), ((2, 3), (10, 20)))

    def test_values_are_written_at_the_place_of_a_file(self):
        heights = hills(30, 40).astype(np.float32)
        terrain = cbvh.terrain(heights, 2, NATIONAL)
        eyes = np.stack(
            [*np.meshgrid(NATIONAL[0] + 2 * np.arange(40.0), NATIONAL[1] - 2 * np.arange(30.0)), heights + 1], -1
        )
        factors = terrain.sky_view_factor(eyes, 4)
        for raster_type in (AREA, POINT):
            source, path = self.national(heights, raster_type), self.path()
            cbvh.write_raster(path, factors[4:, 3:], source, row=4, column=3)
            read = cbvh.read_raster(path)
            np.testing.assert_array_equal(read["heights"], factors[4:, 3:])
            self.assertEqual(read["origin"], (NATIONAL[0] + 6, NATIONAL[1] - 8))

    @unittest.skipUnless(shutil.which("gdalinfo"), "requires Debian's gdal-bin")
    def test_gdal_agrees_about_places_and_types(self):
        heights = hills(30, 40).astype(np.float32)
        terrain = cbvh.terrain(heights, 2, NATIONAL)
        rotated, path = self.path(), self.path()
        matrix = [1.5, 0.75, 0, NATIONAL[0], 0.5, -2, 0, NATIONAL[1], 0, 0, 0, 0, 0, 0, 0, 1]
        write_tiff(rotated, heights, [(34264, matrix)], keys=geo_keys(AREA))
        self.assertIsNone(cbvh.read_raster(rotated)["cell"])
        cbvh.write_raster(path, heights[5:, 4:], rotated, row=5, column=4)
        transform = gdal(path)["geoTransform"]
        x, y = NATIONAL[0] + 4 * 1.5 + 5 * 0.75, NATIONAL[1] + 4 * 0.5 - 5 * 2
        np.testing.assert_allclose(transform, [x, 1.5, 0.75, y, 0.5, -2], rtol=0, atol=1e-9)
        source = self.national(heights)
        for values, bands, name in (
            (np.zeros((30, 40, 3), np.float32), 3, "Float32"),
            (np.zeros((30, 40), bool), 1, "Byte"),
            (np.zeros((30, 40), np.int32), 1, "Int32"),
            (np.zeros((30, 40)), 1, "Float64"),
        ):
            for like, options in ((terrain, {"crs": source}), (source, {})):
                cbvh.write_raster(path, values, like, **options)
                info = gdal(path)
                self.assertEqual(info["geoTransform"], [NATIONAL[0] - 1, 2, 0, NATIONAL[1] + 1, 0, -2])
                self.assertIn('ID["EPSG",25832]', info["coordinateSystem"]["wkt"])
                self.assertEqual([band["type"] for band in info["bands"]], [name] * bands)
                self.assertEqual("noDataValue" in info["bands"][0], "Float" in name)

    def test_invalid_input_is_reported_by_name(self):
        terrain, values, path = cbvh.terrain(np.zeros((4, 5))), np.zeros((4, 5)), self.path()
        plain, source = self.path(), self.national(np.zeros((4, 5), np.float32))
        write_tiff(plain, np.zeros((4, 5), np.float32))
        placed = self.path()
        write_tiff(placed, np.zeros((4, 5), np.float32), [(33550, [2, 2, 0]), (33922, [0, 0, 0, 1, 2, 0])])
        self.assertEqual([cbvh.read_raster(plain)[name] for name in ("cell", "origin")], [None, None])
        for error, text, call in (
            (ValueError, r"values: .*\(20,\).*\(rows, columns\)", lambda: cbvh.write_raster(path, [0] * 20, terrain)),
            (ValueError, r"values: .*\(0, 5\)", lambda: cbvh.write_raster(path, values[:0], terrain)),
            (TypeError, "values: ", lambda: cbvh.write_raster(path, values + 1j, terrain)),
            (ValueError, "row: is 1, .*4 x 5", lambda: cbvh.write_raster(path, values, terrain, row=1)),
            (ValueError, "column: is -1, ", lambda: cbvh.write_raster(path, values, source, column=-1)),
            (ValueError, "like: .*no georeference", lambda: cbvh.write_raster(path, values, plain)),
            (ValueError, "crs: .*no georeference", lambda: cbvh.write_raster(path, values, terrain, crs=plain)),
            (ValueError, "crs: .*no coordinate system", lambda: cbvh.write_raster(path, values, terrain, crs=placed)),
            (cbvh.Error, "like: .*regular", lambda: cbvh.write_raster(path, values, os.path.dirname(path))),
            (cbvh.Error, "input", lambda: cbvh.write_raster(placed, values, placed)),
            (TypeError, "crs: .*None", lambda: cbvh.write_raster(path, values, source, crs=source)),
            (cbvh.Error, "like: .*none.*exist", lambda: cbvh.write_raster(path, values, path + "none")),
            (TypeError, "like: ", lambda: cbvh.write_raster(path, values, 3)),
            (cbvh.Error, "2.tif: .*input", lambda: cbvh.write_raster(plain, values, terrain)),
            (cbvh.Error, "none", lambda: cbvh.write_raster(path + "/none/a.tif", values, terrain)),
            (cbvh.Error, "none", lambda: cbvh.read_raster(path + "none")),
            (cbvh.Error, r"\.tif: unknown channel 'a'", lambda: cbvh.read_raster(source, channel="a")),
            (TypeError, "cell: ", lambda: cbvh.terrain(**cbvh.read_raster(plain))),
            (ValueError, "encoding: .*mapbox", lambda: cbvh.read_raster(source, encoding="x")),
            (ValueError, "channel: .*none", lambda: cbvh.read_raster(source, channel="Y", encoding="mapbox")),
            (cbvh.Error, "1 channel.* red.* encoding", lambda: cbvh.read_raster(source, encoding="mapbox")),
            (ValueError, "threads: .*-1", lambda: cbvh.read_raster(source, threads=-1)),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                call()
        self.assertFalse(os.path.exists(path))


if __name__ == "__main__":
    unittest.main()
