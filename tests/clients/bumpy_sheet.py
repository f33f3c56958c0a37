# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Renders a bumpy sheet of 1000 x 1000 smooth quads under a low sun, with Cycles on the CPU.

    blender -b --python-exit-code 1 --python bumpy_sheet.py -- FOLDER SAMPLES EDGE COMPRESSION ...

EDGE is the length of the quads' edges in the plane of the sheet. Renders a picture for each COMPRESSION: "plain" for
none, "default", "lossless", or a number N for a spacing of 1/N of the median edge. Writes each as
FOLDER/COMPRESSION.exr, and as FOLDER/COMPRESSION.floats: one 32-bit float per pixel, in rows from the bottom to the
top. The scene is gray, so one channel suffices. Cycles creates an Embree device for each picture, and our libembree3
then reads EMBREE_CBVH. The interposer reads it once, so it must get only one COMPRESSION.
"""

import os
import sys
import time

import bpy
import numpy as np

QUADS = 1000
SUN_DEGREES = 78  # from the vertical: shadow rays graze the sheet

folder, samples, edge, *compressions = sys.argv[sys.argv.index("--") + 1 :]
edge = float(edge)
size = QUADS * edge

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_grid_add(x_subdivisions=QUADS, y_subdivisions=QUADS, size=size)
sheet = bpy.context.object
mesh = sheet.data
assert len(mesh.polygons) == QUADS * QUADS
vertices = np.empty((len(mesh.vertices), 3), np.float32)
mesh.vertices.foreach_get("co", vertices.ravel())
x, y = (vertices[:, :2].astype(np.float64) / edge).T  # in quads
waves = 2.0 * np.sin(x / 13) * np.cos(y / 17) + 0.5 * np.sin((x + 2 * y) / 9) + 0.2 * np.sin((3 * x - y) / 11)
vertices[:, 2] = edge * waves
mesh.vertices.foreach_set("co", vertices.ravel())
mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
mesh.update()
white = bpy.data.materials.new("white")
white.use_nodes = True
white.node_tree.nodes.clear()
diffuse = white.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
output = white.node_tree.nodes.new("ShaderNodeOutputMaterial")
white.node_tree.links.new(diffuse.outputs[0], output.inputs[0])
mesh.materials.append(white)

lamp = bpy.data.lights.new("sun", "SUN")
lamp.angle = 0
lamp.energy = 3 / np.cos(np.radians(SUN_DEGREES))
sun = bpy.data.objects.new("sun", lamp)
sun.rotation_euler = (np.radians(SUN_DEGREES), 0, np.radians(25))
# Weak light from all directions: no pixel is black, so differences can be relative.
world = bpy.data.worlds.new("sky")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.1, 0.1, 1)
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location = (0, -60 * edge, 70 * edge)
camera.rotation_euler = (np.radians(40), 0, 0)
camera.data.lens = 36  # equal to the sensor width: the width of the view equals its distance
camera.data.clip_start, camera.data.clip_end = edge, 2 * size

scene = bpy.context.scene
scene.collection.objects.link(sun)
scene.collection.objects.link(camera)
scene.world, scene.camera = world, camera
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = int(samples)
scene.cycles.seed = 1
scene.cycles.max_bounces = 0
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 640, 360, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"

edges = np.linalg.norm(np.diff(vertices.reshape(QUADS + 1, QUADS + 1, 3), axis=1), axis=2)
for compression in compressions:
    spacing = {"default": "", "lossless": ",max_error=0"}
    if compression == "plain":
        os.environ["EMBREE_CBVH"] = "0"
    elif compression in spacing:
        os.environ["EMBREE_CBVH"] = "1,verbose" + spacing[compression]
    else:
        os.environ["EMBREE_CBVH"] = f"1,verbose,max_error={np.median(edges) / int(compression):.9g}"
    picture = os.path.join(folder, compression)
    scene.render.filepath = picture + ".exr"
    print("begin:", compression, file=sys.stderr, flush=True)
    began = time.monotonic()
    bpy.ops.render.render(write_still=True)
    print(f"end: {time.monotonic() - began:.1f} s", file=sys.stderr, flush=True)
    image = bpy.data.images.load(picture + ".exr")
    channels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(channels)
    channels[::4].tofile(picture + ".floats")
    bpy.data.images.remove(image)

NAMES = ("libembree3.so", "libembree4.so", "libembree_cbvh_interposer.so")
with open("/proc/self/maps") as maps:
    print(
        "libraries:",
        *sorted({line.split()[-1] for line in maps if any(name in line for name in NAMES)}),
        file=sys.stderr,
    )
