# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# %% [markdown]
# # The triangles of a skin
#
# What does a ray really hit? This looks up the triangle of every pixel's hit as it is stored, shades by its normal, draws its
# edges, and says how far the ray's own point is from the triangle's plane: an offset that is larger is enough for rays that
# start there.
#
# The cells are those of a notebook (Visual Studio Code, Spyder and Jupytext read them); as a program it writes the picture
# beside where it is started.

# %%
import numpy as np

try:
    import matplotlib.pyplot as plt
except ImportError as error:
    raise SystemExit("matplotlib is not installed for this Python: install the package python3-matplotlib") from error

import embree_cbvh as cbvh

SCENE = "frog"
LEVEL = 3
SIZE = (640, 480)

# %% [markdown]
# ## A hit, and its triangle

# %%
model = cbvh.Model.scene(SCENE)
scene = cbvh.build(model, "cvert", LEVEL)
camera = scene.camera("close", SIZE)
origins, directions = cbvh.primary_rays(camera)
hits = scene.intersect(origins, directions)
triangles = scene.triangles(hits).astype(np.float64)  # of each pixel, NaN where a ray misses
a, b, c = (triangles[..., i, :] for i in range(3))
normals = np.cross(b - a, c - a)
area2 = np.linalg.norm(normals, axis=-1, keepdims=True)
normals /= area2

# %% [markdown]
# ## Where in it
#
# The weights of the three vertices at the hit. At an edge one of them is 0.

# %%
with np.errstate(invalid="ignore"):
    points = origins + hits.t[..., None] * np.asarray(directions, np.float64)
    off = np.abs(np.sum((points - a) * normals, -1))
    weights = np.stack([np.sum(np.cross(q - p, points - p) * normals, -1) for p, q in ((b, c), (c, a), (a, b))], -1) / area2
print(f"{np.count_nonzero(hits.hit)} hits, at most {np.nanmax(off):.2g} off the planes of their triangles")

# %% [markdown]
# ## All of the surface
#
# Quads as they are stored, for an export or a bake: `vertices[quads]` has the four corners of each.

# %%
mesh = scene.tessellation()
print(f"{len(mesh['quads'])} quads of {mesh['primID'].max() + 1} faces, {len(mesh['vertices'])} vertices")

# %%
light = np.array([0.4, 0.8, 0.45]) / np.linalg.norm([0.4, 0.8, 0.45])
facing = np.where(np.sum(normals * directions, -1, keepdims=True) > 0, -normals, normals)
shade = 0.25 + 0.75 * np.clip(np.sum(facing * light, -1), 0, 1)
shade = np.where(weights.min(-1) < 0.04, 0.55 * shade, shade)
picture = np.where(hits.hit, np.nan_to_num(shade), 1)
plt.imsave("skin_triangles.png", picture, cmap="gray", vmin=0, vmax=1)
