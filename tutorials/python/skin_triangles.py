# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# %% [markdown]
# # The triangles of a skin
#
# Which triangle does a ray hit? This example reads the stored triangle of every pixel's hit, shades by its normal, and
# draws its edges. It also prints the distance of hit points from the planes of their triangles: an offset above this is
# sufficient for rays that start there.
#
# The cells are notebook cells (Visual Studio Code, Spyder and Jupytext read them). As a program it writes the picture
# to the current folder.

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
model = cbvh.Model.generate(SCENE)
scene = cbvh.build(model, "cvert", LEVEL)
camera = scene.camera("close", SIZE)
origins, directions = cbvh.primary_rays(camera)
hits = scene.intersect(origins, directions)
triangles = scene.triangles(hits).astype(np.float64)  # per pixel, NaN for a miss
a, b, c = (triangles[..., i, :] for i in range(3))
normals = np.cross(b - a, c - a)
area2 = np.linalg.norm(normals, axis=-1, keepdims=True)
normals /= area2

# %% [markdown]
# ## Barycentric coordinates
#
# The weights of the three vertices at the hit. On an edge, one of them is 0.

# %%
with np.errstate(invalid="ignore"):
    points = origins + hits.t[..., None] * np.asarray(directions, np.float64)
    off = np.abs(np.sum((points - a) * normals, -1))
    edges = ((b, c), (c, a), (a, b))
    weights = np.stack([np.sum(np.cross(q - p, points - p) * normals, -1) for p, q in edges], -1) / area2
print(f"{np.count_nonzero(hits.hit)} hits, at most {np.nanmax(off):.2g} away from the planes of their triangles")

# %% [markdown]
# ## The whole surface
#
# The stored quads, for an export or a bake: `vertices[quads]` contains the four corners of each quad.

# %%
mesh = scene.stored_mesh()
print(f"{len(mesh['quads'])} quads of {mesh['primID'].max() + 1} faces, {len(mesh['vertices'])} vertices")

# %%
light = np.array([0.4, 0.8, 0.45]) / np.linalg.norm([0.4, 0.8, 0.45])
facing = np.where(np.sum(normals * directions, -1, keepdims=True) > 0, -normals, normals)
shade = 0.25 + 0.75 * np.clip(np.sum(facing * light, -1), 0, 1)
shade = np.where(weights.min(-1) < 0.04, 0.55 * shade, shade)
picture = np.where(hits.hit, np.nan_to_num(shade), 1)
plt.imsave("skin_triangles.png", picture, cmap="gray", vmin=0, vmax=1)
