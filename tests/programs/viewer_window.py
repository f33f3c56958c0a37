#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""cbvh_viewer in a real window: it starts, keys switch what it shows, the window
shows and saves, to the byte, what --screenshot writes without one.

usage: viewer_window.py PATH/TO/cbvh_viewer

Xvfb keeps its screen in a file of the XWD format, which is read here."""

import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

SIZE = (480, 360)
TIMEOUT = 60  # seconds, for anything to happen


def read_ppm(path):
    """(width, height, RGB bytes) of a binary PPM."""
    with open(path, "rb") as file:
        data = file.read()
    fields, at = [], 0
    while len(fields) < 4:
        end = at
        while not data[end : end + 1].isspace():
            end += 1
        fields.append(data[at:end])
        at = end + 1
    return int(fields[1]), int(fields[2]), data[at:]


def read_screen(path, box):
    """The same of a rectangle (x, y, width, height) of an XWD file with 32 bits a
    pixel; nothing while it is not that."""
    with open(path, "rb") as file:
        data = file.read()
    header = struct.unpack(">25I", data[:100])
    big_endian, bits, stride = header[7], header[11], header[12]
    if bits != 32:
        raise SystemExit(f"FAILED: the screen has {bits} bits a pixel")
    begin = header[0] + 12 * header[19]
    red, green, blue = (1, 2, 3) if big_endian else (2, 1, 0)
    x, y, width, height = box
    rgb = bytearray()
    for row in range(y, y + height):
        line = data[begin + row * stride + 4 * x : begin + row * stride + 4 * (x + width)]
        pixels = bytearray(3 * width)
        pixels[0::3], pixels[1::3], pixels[2::3] = line[red::4], line[green::4], line[blue::4]
        rgb += pixels
    return width, height, bytes(rgb)


def wait_for(what, condition):
    """The first true value of condition()."""
    end = time.monotonic() + TIMEOUT
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.1)
    raise SystemExit(f"FAILED: {what}, after {TIMEOUT} s")


class Session:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-fbdir", folder, "-nolisten", "tcp"],
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as file:
            number = file.readline().strip()
        if not number:
            raise SystemExit("FAILED: Xvfb does not start")
        self.environment = dict(os.environ, DISPLAY=":" + number, LIBGL_ALWAYS_SOFTWARE="1")
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.viewer = None

    def close(self):
        for process in (self.viewer, self.server):
            if process and process.poll() is None:
                process.kill()
                process.wait()

    def xdotool(self, *arguments):
        done = subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False)
        return done.stdout.strip()

    def screenshot(self, name, *options):
        """What the program writes without a window."""
        path = os.path.join(self.folder, name + ".ppm")
        environment = {k: v for k, v in self.environment.items() if k != "DISPLAY"}
        done = subprocess.run([self.program, "--scene", "cube", "--size", "%dx%d" % SIZE, *options, "--screenshot", path],
                              env=environment, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"FAILED: no screenshot of {name}: {done.stderr}")
        return read_ppm(path)

    def start(self, *options, scene=("--scene", "cube")):
        with open(os.path.join(self.folder, "log"), "w") as log:
            self.viewer = subprocess.Popen([self.program, *scene, "--size", "%dx%d" % SIZE, *options],
                                           env=self.environment, cwd=self.folder, stderr=log)
        def window():
            if self.viewer.poll() is not None:
                with open(os.path.join(self.folder, "log")) as log:
                    raise SystemExit(f"FAILED: the viewer ended with status {self.viewer.returncode}: {log.read()}")
            return self.xdotool("search", "--onlyvisible", "--name", "cbvh_viewer").split("\n")[0]
        self.window = wait_for("no window", window)
        self.xdotool("mousemove", 790, 590)  # the cursor is drawn into the screen
        def focused(): # there is no window manager to do it
            self.xdotool("windowfocus", self.window)
            return self.xdotool("getwindowfocus", "-f") == self.window
        wait_for("the window does not take the focus", focused)

    def key(self, *keys):
        for key in keys:
            self.xdotool("key", key)

    def screen(self):
        lines = self.xdotool("getwindowgeometry", "--shell", self.window).split("\n")
        g = {k: int(v) for k, v in (line.split("=") for line in lines if "=" in line) if k != "WINDOW"}
        return read_screen(os.path.join(self.folder, "Xvfb_screen0"), (g["X"], g["Y"], g["WIDTH"], g["HEIGHT"]))

    def shows(self, what, picture):
        wait_for(f"the window does not show {what}", lambda: self.screen() == picture)
        print(f"shows {what}")

    def ends(self, status):
        wait_for("the viewer does not end", lambda: self.viewer.poll() is not None)
        if self.viewer.returncode != status:
            raise SystemExit(f"FAILED: the viewer ends with status {self.viewer.returncode}, not {status}")


def run(session, folder):
    grid = session.screenshot("grid", "--level", "4", "--representation", "grid")
    leaf = session.screenshot("leaf", "--level", "4", "--representation", "cleaf")
    finer = session.screenshot("finer", "--level", "5", "--representation", "cleaf^3")
    split = session.screenshot("split", "--level", "5", "--representation", "cleaf^3,cvoxel^2")
    normals = session.screenshot("normals", "--level", "5", "--representation", "cleaf^3,cvoxel^2", "--mode", "normals")
    error = session.screenshot("error", "--level", "5", "--representation", "cleaf^3,cvoxel^2", "--mode", "error")
    if len({picture[2] for picture in (grid, leaf, finer, split, normals, error)}) != 6:
        raise SystemExit("FAILED: switching changes nothing to see")

    session.start("--level", "4", "--representation", "grid", "--picture", "saved.ppm")

    def overlaid():
        screen = session.screen()
        return screen != grid and screen[2][-1000:] == grid[2][-1000:]
    wait_for("there is no picture with an overlay", overlaid)
    session.key("h")
    session.shows("GRID", grid)
    session.key("5")
    session.shows("cLEAF", leaf)
    session.key("p")
    saved = os.path.join(folder, "saved.ppm")
    wait_for("no picture is saved", lambda: os.path.exists(saved))
    if read_ppm(saved) != leaf:
        raise SystemExit("FAILED: the saved picture is not the screenshot")
    session.key("l", "n")
    session.shows("cLEAF^3 at level 5", finer)
    session.key("x", "shift+4")
    session.shows("cVOXEL beside it", split)
    session.key("m")
    session.shows("normals", normals)
    session.key("m")
    session.shows("errors", error)

    # The mouse orbits, R goes back.
    def drag():
        # With pauses: GLFW asks where the mouse is now, not where it was at the click.
        for step in ("mousemove", 240, 180), ("mousedown", 1), ("mousemove", 300, 200), ("mouseup", 1), ("mousemove", 790, 590):
            session.xdotool(*step)
            time.sleep(0.2)
        return session.screen() != error
    wait_for("dragging does not move the camera", drag)
    session.key("r")
    session.shows("where it started", error)
    session.xdotool("windowsize", session.window, 400, 300)
    wait_for("the window has no picture of another size",
             lambda: (lambda s: s[:2] == (400, 300) and any(s[2]))(session.screen()))
    if os.path.exists(os.path.join(folder, "imgui.ini")):
        raise SystemExit("FAILED: a file is left behind")
    session.key("q")
    session.ends(0)

    session.start("--level", "4")
    session.viewer.send_signal(signal.SIGINT)
    session.ends(130)

    # Closing does not wait for a build, here of 268 million quads.
    n = 64
    with open(os.path.join(folder, "plane.obj"), "w") as file:
        for i in range((n + 1) ** 2):
            file.write(f"v {i % (n + 1)} {i // (n + 1)} 0\n")
        for i in range(n * n):
            v = i // n * (n + 1) + i % n + 1
            file.write(f"f {v} {v + 1} {v + n + 2} {v + n + 1}\n")
    session.start("--level", "8", scene=("--cage", "plane.obj"))
    session.key("q")
    session.ends(0)
    with open(os.path.join(folder, "log")) as log:
        text = log.read()
    if "cVERT: build: stopped" not in text:
        raise SystemExit(f"FAILED: the build was not stopped: {text}")


def main():
    program = os.path.abspath(sys.argv[1])
    for tool in ("Xvfb", "xdotool"):
        if not shutil.which(tool):
            print(f"skipped: no program named {tool}, see scripts/packages")
            return 77
    folder = tempfile.mkdtemp()
    session = Session(program, folder)
    try:
        run(session, folder)
    finally:
        session.close()
        shutil.rmtree(folder)
    print("all well")
    return 0


if __name__ == "__main__":
    sys.exit(main())
