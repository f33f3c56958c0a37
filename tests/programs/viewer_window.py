#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Tests cbvh_viewer in a real window: it starts, keys and mouse have their effects, dropped files are opened,
obsolete work stops, and the window shows and saves exactly the picture that --no-window writes.

    viewer_window.py PATH/TO/cbvh_viewer PATH/TO/cbvh_render
"""

import importlib.util
import math
import os
import shutil
import signal
import sys
import tempfile

from window_driver import SIZE, Session, read_ppm, wait_for


def fail(text):
    raise SystemExit(f"FAILED: {text}")


def part(picture, x, y, width, height):
    """Returns a rectangle of (width, height, RGB bytes)."""
    rows = (3 * (row * picture[0] + x) for row in range(y, y + height))
    return b"".join(picture[2][at : at + 3 * width] for at in rows)


# --- display --------------------------------------------------------------------------------


def test_switching(session):
    grid = session.screenshot("grid", "--level", "4", "--representation", "grid")
    leaf = session.screenshot("leaf", "--level", "4", "--representation", "cleaf")
    finer = session.screenshot("finer", "--level", "5", "--representation", "cleaf^0")
    voxel = session.screenshot("voxel", "--level", "5", "--representation", "cvoxel")
    split = session.screenshot("split", "--level", "5", "--representation", "cleaf^0,cvoxel")
    normals = session.screenshot("normals", "--level", "5", "--representation", "cleaf^0,cvoxel", "--show", "normals")
    error = session.screenshot("error", "--level", "5", "--representation", "cleaf^0,cvoxel", "--show", "error")
    if len({picture[2] for picture in (grid, leaf, finer, voxel, split, normals, error)}) != 7:
        fail("switching has no visible effect")

    session.start("--level", "4", "--representation", "grid", "--output", "saved.ppm")
    session.key("h")
    session.shows("GRID", grid)
    session.key("5")
    session.shows("cLEAF", leaf)
    session.key("p")
    saved = os.path.join(session.folder, "saved.ppm")
    wait_for("no picture is saved", lambda: os.path.exists(saved))
    if read_ppm(saved) != leaf:
        fail("the saved picture is not the screenshot")
    session.key("l", "n")
    session.shows("cLEAF^0 at level 5", finer)
    session.key("x", "shift+4")
    session.shows("cVOXEL next to it", split)

    # Dragging moves the line between the halves, but not the camera.
    camera = session.camera()
    session.drag((SIZE[0] // 2, 300), (360, 300))

    def divided():
        screen = session.screen()
        return all(
            part(screen, x, 0, width, SIZE[1]) == part(picture, x, 0, width, SIZE[1])
            for picture, x, width in ((finer, 0, 360), (voxel, 361, SIZE[0] - 361))
        )

    wait_for("the split line does not follow the mouse", divided)
    if part(session.screen(), 360, 0, 1, SIZE[1]) != b"\xff" * 3 * SIZE[1]:
        fail("no line between the halves")
    if session.camera() != camera:
        fail("dragging the split line moves the camera")
    session.drag((360, 300), (SIZE[0] // 2, 300))
    session.shows("the line back in the middle", split)

    session.key("m")
    session.shows("normals", normals)
    session.key("m")
    session.shows("errors", error)
    session.xdotool("windowsize", session.window, 400, 300)
    wait_for(
        "the window has no picture of another size",
        lambda: (lambda s: s[:2] == (400, 300) and any(s[2]))(session.screen()),
    )
    if os.path.exists(os.path.join(session.folder, "imgui.ini")):
        fail("a file was left")
    session.key("q")
    session.ends(0)


# The mouse position is read at the start of a frame, so dragging requires short frames: one sample, then rest.
QUICK = ("--level", "4", "--samples", "1")


# --- files --------------------------------------------------------------------------------


def write_box(path):
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (4, 3, 7, 8), (1, 5, 7, 3), (2, 4, 8, 6)]
    with open(path, "w") as file:
        for corner in corners:
            file.write("v %d %d %d\n" % corner)
        file.write("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n")
        for face in faces:
            file.write("f " + " ".join(f"{v}/{i + 1}" for i, v in enumerate(face)) + "\n")


def write_bumps(path):
    n = 64
    with open(path, "wb") as file:
        file.write(b"P5 %d %d 255\n" % (n, n))
        file.write(bytes(int(128 + 127 * math.sin(x / 4) * math.sin(y / 4)) for y in range(n) for x in range(n)))


def write_plane(path):
    """4096 quads in a plane, which give 268 million quads at level 8."""
    n = 64
    with open(path, "w") as file:
        for i in range((n + 1) ** 2):
            file.write(f"v {i % (n + 1)} {i // (n + 1)} 0\n")
        for i in range(n * n):
            v = i // n * (n + 1) + i % n + 1
            file.write(f"f {v} {v + 1} {v + n + 2} {v + n + 1}\n")


def test_files(session):
    import xdnd

    box, bumps, bad = (os.path.join(session.folder, name) for name in ("box with spaces.obj", "bumps.pgm", "bad.obj"))
    write_box(box)
    write_bumps(bumps)
    with open(bad, "w") as file:
        file.write("v 0 0 0\nv 1 0 0\nf 1 2\n")
    level = QUICK
    smooth = session.screenshot("smooth", *level, scene=(box,))
    rough = session.screenshot("rough", *level, scene=(bumps, box))
    if smooth == rough or rough != session.screenshot("same", *level, scene=("--cage", box, "--height", bumps)):
        fail("files without options differ from --cage and --height")

    def drop(*paths):
        xdnd.drop(session.environment["DISPLAY"], int(session.window), paths)
        print("dropped", *map(os.path.basename, paths))

    def shown_from_its_start(what, picture):
        """A new map keeps the camera. R resets it to the map's own view."""

        def shown():
            session.key("r")
            return session.screen() == picture

        wait_for(f"the window does not show {what}", shown)
        print(f"shows {what}")

    session.start(*level, scene=())
    session.key("h")
    drop(bumps)  # a map without a cage cannot be shown
    drop(box)
    session.shows("the cage", smooth)
    session.drag((240, 180), (300, 200))
    camera = session.camera()
    before = session.screen()
    drop(bumps)
    wait_for(
        "the map is not shown", lambda: session.title().endswith(" - box with spaces") and session.screen() != before
    )
    if session.camera() != camera:
        fail("another map moves the camera")
    shown_from_its_start("the cage with its map", rough)
    drop(bad)
    wait_for("no message about the bad cage", lambda: "bad.obj:3" in session.read("log"))
    session.shows("what it showed before the bad cage", rough)
    session.key("h")
    session.key("h")
    drop(box)
    shown_from_its_start("the cage without the map", smooth)
    drop(bumps, box)
    shown_from_its_start("both", rough)

    # The amplitude in the panel is edited after a double click.
    strong = session.screenshot("strong", *level, "--amplitude", "0.06", scene=(bumps, box))
    session.key("h")
    wait_for("no panel", lambda: session.screen() != rough)
    session.mouse(
        ("mousemove", 80, 105),
        ("click", "--repeat", 2, "--delay", 80, 1),
        ("key", "ctrl+a"),
        ("type", "0.06"),
        ("key", "Return"),
    )
    session.move_cursor_out()
    session.key("h")
    shown_from_its_start("another amplitude", strong)
    if "box" not in session.title():
        fail(f"the title is '{session.title()}'")

    # Keys do not change the kind and level of compressed surfaces. A cage can be opened afterwards.
    compressed = os.path.join(session.folder, "box.cbvh")
    session.render(box, "--level", "4", "--save", compressed)
    saved = session.screenshot("compressed", "--samples", "1", scene=(compressed,))
    drop(compressed)
    shown_from_its_start("compressed surfaces", saved)
    session.key("x", "l", "1")
    shown_from_its_start("compressed surfaces independently of keys", saved)
    drop(box)
    wait_for("the cage is not shown again", lambda: session.title().endswith(" - box with spaces"))
    session.key("q")
    session.ends(0)


# --- work in the background ---------------------------------------------------------------


def test_background(session):
    # The window appears while maps are generated, with a percentage. Closing it stops the work.
    session.start(scene=("--scene", "trex"))
    wait_for("no percentage of the maps", lambda: "loading trex, " in session.title() and session.title().endswith("%"))
    session.key("q")
    session.ends(0)
    if "loading trex: stopped" not in session.read("log"):
        fail(f"generating maps was not stopped: {session.read('log')}")
    for folder in session.folder, os.path.join(session.folder, "cache", "embree-cbvh"):
        left = [name for name in os.listdir(folder) if name.endswith(".exr")]
        if left:
            fail(f"a partial map was left: {left}")

    # Obsolete builds stop, and so do builds when the window is closed.
    plane = os.path.join(session.folder, "plane.obj")
    write_plane(plane)
    coarse = session.screenshot("plane", "--level", "3", scene=(plane,))
    session.start("--level", "8", scene=(plane,))
    session.key("h")
    session.says("building cTILE, level 8")
    session.key(*["shift+l"] * 5)
    session.shows("a coarser level at once", coarse)
    if "building cTILE, level 8: stopped" not in session.read("log"):
        fail(f"the finer level was not stopped: {session.read('log')}")
    session.key(*["l"] * 5)
    session.says("building cTILE, level 8")
    session.key("q")
    session.ends(0)
    if session.read("log").count("building cTILE, level 8: stopped") != 2:
        fail(f"the last build was not stopped: {session.read('log')}")

    session.start("--level", "4")
    session.viewer.send_signal(signal.SIGINT)
    session.ends(130)

    # Escape asks for confirmation, which can be declined.
    picture = session.screenshot("asked", *QUICK)
    session.start(*QUICK)
    session.key("h")
    session.shows("the picture", picture)
    for answer in ("Escape", "Return"):
        session.key("Escape")
        wait_for("escape does not ask", lambda: session.screen() != picture)
        session.key(answer)
        if answer == "Escape":
            session.shows("the picture without the question", picture)
    session.ends(0)


def main():
    program, render = map(os.path.abspath, sys.argv[1:3])
    missing = [tool for tool in ("Xvfb", "xdotool") if not shutil.which(tool)]
    if not importlib.util.find_spec("Xlib"):
        missing.append("Xlib for Python")
    if missing:
        print(f"skipped: no {' and no '.join(missing)}, see scripts/packages")
        return 77
    folder = tempfile.mkdtemp()
    session = Session(program, folder, render)
    try:
        for test in (test_switching, test_files, test_background):
            print(f"--- {test.__name__}", flush=True)
            test(session)
    finally:
        session.close()
        shutil.rmtree(folder)
    print("passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
