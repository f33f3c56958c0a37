# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Renders a subdivided head on a floor with Blender's Cycles, which uses Embree.   ... -- PICTURE"""

import sys

import bpy

bpy.ops.wm.read_factory_settings()
for thing in list(bpy.data.objects):
    if thing.type == "MESH":
        bpy.data.objects.remove(thing)
bpy.ops.mesh.primitive_monkey_add(size=3)
bpy.context.object.modifiers.new("subdivision", "SUBSURF").render_levels = 3
bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1.5))

scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = 16
scene.cycles.seed = 1
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 240, 160, 100
scene.render.image_settings.file_format = "BMP"  # a format without dates
scene.render.filepath = sys.argv[sys.argv.index("--") + 1]
bpy.ops.render.render(write_still=True)
assert any("libembree3.so.3" in line for line in open("/proc/self/maps")), "Cycles does not use Embree"
