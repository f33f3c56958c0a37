# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# %% [markdown]
# # Speed against error
#
# How fast is a representation, and how far are its hits from the true surface? This example builds one model at several
# levels in several representations, traces the same rays through all of them, and plots speed against error.
#
# The cells are notebook cells (Visual Studio Code, Spyder and Jupytext read them). As a program it writes the pictures
# to the current folder. The scene's height map, 134 MB, is generated once and kept in your cache folder.

# %%
import statistics

import numpy as np

try:
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator, NullFormatter
except ImportError as error:
    raise SystemExit("matplotlib is not installed for this Python: install the package python3-matplotlib") from error

import embree_cbvh as cbvh

SCENE = "trex"
LEVELS = (3, 4, 5)
REPRESENTATIONS = ("grid", "cgrid", "cvoxel", "cleaf", "cvert")
SIZE = (640, 480)
ROUNDS = 5


def show(phase: str, fraction: float) -> None:
    print(f"\r{phase}: {fraction:.0%} ", end="" if fraction < 1 else "\n")


# %% [markdown]
# ## The model and its rays
#
# Your own model is `cbvh.Model(cbvh.Cage.load("body.obj"), "skin.exr", amplitude=0.006)`, or a cage and a height map
# from arrays. All representations trace the same rays: rays of a camera, in tiles as in renderers, and rays that bounce
# off the visible surface.

# %%
model = cbvh.Model.generate(SCENE, progress=show)
grid = cbvh.build(model, "grid", LEVELS[-1], progress=show)
camera = grid.camera("full", SIZE)
pixels = cbvh.primary_rays(camera)
diagonal = float(np.linalg.norm(grid.bounds[1] - grid.bounds[0]))
rays = {
    "coherent": cbvh.coherent_rays(camera),
    "incoherent": cbvh.bounce_rays(grid.intersect(*pixels), *pixels, offset=1e-4 * diagonal),
}
del grid  # it is rebuilt below

# %% [markdown]
# ## Building and measuring
#
# A level stays in memory until the next one is built. Representations are timed alternately on one core, and the median
# is used, so that other load on the machine affects all of them. Errors are distances from the displaced limit surface
# in pixels: they include errors of the tessellation, which GRID has, too, and errors of the compression.

# %%
rows = []
for level in LEVELS:
    scenes = [cbvh.build(model, name, level, progress=show) for name in REPRESENTATIONS]
    seconds: "dict[tuple[cbvh.ModelScene, str], list[float]]" = {(s, kind): [] for s in scenes for kind in rays}
    for _ in range(ROUNDS):
        for (scene, kind), measured in seconds.items():
            measured.append(scene.trace_seconds(*rays[kind], coherent=kind == "coherent"))
    for scene in scenes:
        hits = scene.intersect(*pixels)
        row = {
            "representation": scene.representation,
            "level": level,
            "bytes": scene.statistics()["bytes_per_quad"],
            "error": scene.true_errors(hits, *pixels, camera.pixel_size, count=2000)["median_pixels"],
        }
        for kind in rays:
            row[kind] = len(rays[kind][0]) * 1e-6 / statistics.median(seconds[scene, kind])
        rows.append(row)

print(f"{'':10} {'level':>5} {'bytes/quad':>10} {'coherent':>9} {'incoherent':>10} {'median error':>12}")
for row in rows:
    print(
        f"{row['representation']:10} {row['level']:5} {row['bytes']:10.2f} {row['coherent']:9.2f} "
        f"{row['incoherent']:10.2f} {row['error']:9.4f} px"
    )

# %% [markdown]
# ## The plot
#
# One line per representation, one point per level; GRID's points are labeled. The size of a point is proportional to
# the bytes per quad. Up and to the left is better.

# %%
figure, panels = plt.subplots(1, 2, figsize=(11, 4.6), sharex=True, constrained_layout=True)
for panel, kind in zip(panels, rays):
    for name in dict.fromkeys(row["representation"] for row in rows):
        points = [row for row in rows if row["representation"] == name]
        errors, speeds = [row["error"] for row in points], [row[kind] for row in points]
        label = f"{name}, {points[-1]['bytes']:.1f} bytes per quad at level {LEVELS[-1]}"
        (line,) = panel.plot(errors, speeds, label=label)
        panel.scatter(errors, speeds, s=[8 * row["bytes"] for row in points], color=line.get_color(), alpha=0.7)
        for row in points if name == "GRID" else ():
            panel.annotate(
                f"level {row['level']}",
                (row["error"], row[kind]),
                textcoords="offset points",
                xytext=(10, -12),
                fontsize=8,
                color=line.get_color(),
            )
    panel.set_xscale("log")
    panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.xaxis.set_major_formatter("{x:g}")
    panel.xaxis.set_minor_formatter(NullFormatter())
    panel.margins(x=0.12, y=0.1)
    panel.set_ylim(bottom=0)
    panel.set_title(f"{kind} rays, {model.name}")
    panel.set_xlabel("median distance from the true surface, pixels")
    panel.grid(alpha=0.3)
panels[0].set_ylabel("millions of rays per second, one core")
panels[0].legend(loc="lower right", fontsize=8)
figure.savefig("speed_against_error.png", dpi=120)

# %% [markdown]
# ## Where the errors are
#
# Hits are arrays of the picture's shape, so they can be shown directly. The reference is GRID at the same level, so all
# differences are due to the compression.

# %%
reference = scenes[REPRESENTATIONS.index("grid")].intersect(*pixels)
shown = [scene for scene in scenes if scene.representation != "GRID"]
figure, panels = plt.subplots(1, len(shown), figsize=(3.6 * len(shown), 2.8), constrained_layout=True)
for panel, scene in zip(panels, shown):
    hits = scene.intersect(*pixels)
    pixel_errors = cbvh.pixel_errors(hits, reference, camera.pixel_size)
    image = panel.imshow(np.maximum(pixel_errors, 1e-4), norm="log", vmin=1e-4, vmax=10)
    summary = scene.compare(hits, reference, camera.pixel_size)
    title = f"{scene.representation}: median {summary['median_pixels']:.2g}, p99 {summary['p99_pixels']:.2g} px"
    panel.set_title(title, fontsize=10)
    panel.set_axis_off()
figure.colorbar(image, ax=panels, label="pixels")
figure.savefig("errors.png", dpi=120)
plt.show()
