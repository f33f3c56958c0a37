# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Renders Suzanne on a floor, with Cycles on the CPU. Prints the time, which not all versions of Blender do.

    blender -b --python-exit-code 1 --python suzanne.py -- PICTURE [SCENE]

SCENE is one of

    head         subdivided six times and displaced: 4 million triangles (default)
    adaptive     displaced by its material, and subdivided until its edges are about half a pixel long
    deforming    as head; the displacement grows while the shutter is open
    instances    100 smaller copies of head, as instances of one collection
    hair         as head, with 20,000 hairs

The picture of head has 960 x 640 pixels, the others 480 x 320.
"""

import math
import sys
import time

import bpy

words = sys.argv[sys.argv.index("--") + 1 :]
picture, name = words[0], words[1] if len(words) > 1 else "head"
if name not in ("head", "adaptive", "deforming", "instances", "hair"):
    raise SystemExit(f'unknown scene "{name}": expected head, adaptive, deforming, instances or hair')

bpy.ops.wm.read_factory_settings()
for thing in list(bpy.data.objects):
    if thing.type == "MESH":
        bpy.data.objects.remove(thing)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
bpy.ops.mesh.primitive_monkey_add(size=3)
head = bpy.context.object
subdivision = head.modifiers.new("subdivision", "SUBSURF")
subdivision.render_levels = 6


def subdivide_adaptively():
    """Leaves the subdivision to Cycles, which then displaces by the material."""
    if hasattr(subdivision, "use_adaptive_subdivision"):  # Blender 5
        subdivision.use_adaptive_subdivision = True
        subdivision.adaptive_pixel_size = 0.5
    else:
        scene.cycles.feature_set = "EXPERIMENTAL"
        head.cycles.use_adaptive_subdivision = True
        scene.cycles.dicing_rate = 0.5
    material = bpy.data.materials.new("skin")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    noise, displacement = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeDisplacement")
    noise.inputs["Scale"].default_value = 12
    displacement.inputs["Scale"].default_value = 0.06
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    links.new(noise.outputs[0], displacement.inputs["Height"])
    links.new(displacement.outputs[0], output.inputs["Displacement"])
    settings = material if hasattr(material, "displacement_method") else material.cycles
    settings.displacement_method = "DISPLACEMENT"
    head.data.materials.append(material)


if name == "adaptive":
    subdivide_adaptively()
else:
    skin = bpy.data.textures.new("skin", "CLOUDS")
    skin.noise_scale = 0.08
    displace = head.modifiers.new("displacement", "DISPLACE")
    displace.texture, displace.strength, displace.mid_level = skin, 0.06, 0.5
if name == "deforming":
    scene.render.use_motion_blur = True
    for frame, strength in ((0, 0), (2, 0.12)):
        displace.strength = strength
        displace.keyframe_insert("strength", frame=frame)
    scene.frame_set(1)
if name == "instances":
    copies = bpy.data.collections.new("copies")
    scene.collection.children.link(copies)
    for collection in list(head.users_collection):
        collection.objects.unlink(head)
    copies.objects.link(head)
    bpy.context.view_layer.layer_collection.children["copies"].exclude = True
    for i in range(100):
        copy = bpy.data.objects.new(f"copy {i}", None)
        copy.instance_type, copy.instance_collection = "COLLECTION", copies
        copy.location = (0.75 * (i % 10) - 3.4, 0.75 * (i // 10) - 3.4, -1)
        copy.scale = 3 * (0.22,)
        copy.rotation_euler = (0, 0, math.tau * i / 37)
        scene.collection.objects.link(copy)
if name == "hair":
    head.modifiers.new("hair", "PARTICLE_SYSTEM")
    hair = head.particle_systems[0].settings
    hair.type, hair.count, hair.hair_length, hair.render_step = "HAIR", 20000, 0.4, 4

bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1.5))
scene.cycles.device = "CPU"
scene.cycles.samples = 16
scene.cycles.seed = 1
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.render.resolution_x, scene.render.resolution_y = (960, 640) if name == "head" else (480, 320)
scene.render.resolution_percentage = 100
scene.render.filepath = picture
began = time.monotonic()
bpy.ops.render.render(write_still=True)
print(f"rendered: {time.monotonic() - began:.2f} s")
