# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Renders Suzanne, subdivided six times and displaced (4 million triangles), on a floor, with Cycles on the CPU. Prints
the time, which not all versions of Blender do.

    blender -b --python-exit-code 1 --python suzanne.py -- PICTURE
"""

import sys
import time

import bpy

bpy.ops.wm.read_factory_settings()
for thing in list(bpy.data.objects):
    if thing.type == "MESH":
        bpy.data.objects.remove(thing)
bpy.ops.mesh.primitive_monkey_add(size=3)
head = bpy.context.object
head.modifiers.new("subdivision", "SUBSURF").render_levels = 6
skin = bpy.data.textures.new("skin", "CLOUDS")
skin.noise_scale = 0.08
displace = head.modifiers.new("displacement", "DISPLACE")
displace.texture, displace.strength, displace.mid_level = skin, 0.06, 0.5
bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1.5))

scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = 16
scene.cycles.seed = 1
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 960, 640, 100
scene.render.filepath = sys.argv[sys.argv.index("--") + 1]
began = time.monotonic()
bpy.ops.render.render(write_still=True)
print(f"rendered: {time.monotonic() - began:.2f} s")
