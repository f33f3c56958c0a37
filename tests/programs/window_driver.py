# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Runs cbvh_viewer on its own display, sends keys and mouse events, and reads the screen.

Xvfb keeps its screen in a file in XWD format, which this module reads.
"""

import os
import struct
import subprocess
import time
from pathlib import Path

SIZE = (480, 360)
TIMEOUT = 60  # seconds, for any event


def read_ppm(path):
    """Returns (width, height, RGB bytes) of a binary PPM."""
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
    """Returns the same for a rectangle (x, y, width, height) of an XWD file with 32 bits per pixel; None while the
    file is incomplete."""
    with open(path, "rb") as file:
        data = file.read()
    header = struct.unpack(">25I", data[:100])
    big_endian, bits, stride = header[7], header[11], header[12]
    if bits != 32:
        raise SystemExit(f"FAILED: the screen has {bits} bits per pixel")
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
    """Returns the first true value of condition()."""
    end = time.monotonic() + TIMEOUT
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.1)
    raise SystemExit(f"FAILED: {what}, after {TIMEOUT} s")


class Session:
    def __init__(self, program, folder, renderer):
        self.program, self.folder, self.renderer = program, folder, renderer
        read, write = os.pipe()
        self.server = subprocess.Popen(
            # without -noreset, Xvfb restarts when the last program ends, and rejects new ones meanwhile
            [
                "Xvfb",
                "-displayfd",
                str(write),
                "-screen",
                "0",
                "800x600x24",
                "-fbdir",
                folder,
                "-nolisten",
                "tcp",
                "-noreset",
            ],
            pass_fds=[write],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(write)
        with os.fdopen(read) as file:
            number = file.readline().strip()
        if not number:
            raise SystemExit("FAILED: Xvfb does not start")
        self.environment = dict(os.environ, DISPLAY=":" + number, LIBGL_ALWAYS_SOFTWARE="1")
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.environment["XDG_CACHE_HOME"] = os.path.join(folder, "cache")
        self.viewer = None

    def close(self):
        for process in (self.viewer, self.server):
            if process and process.poll() is None:
                process.kill()
                process.wait()

    def xdotool(self, *arguments):
        done = subprocess.run(
            ["xdotool", *map(str, arguments)],
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            check=False,
        )
        return done.stdout.strip()

    def screenshot(self, name, *options, scene=("--scene", "cube"), size=SIZE):
        """Returns the picture that the program writes without a window."""
        path = os.path.join(self.folder, name + ".ppm")
        environment = {k: v for k, v in self.environment.items() if k != "DISPLAY"}
        done = subprocess.run(
            [self.program, *scene, "--size", "%dx%d" % size, *options, "--no-window", "--output", path],
            env=environment,
            cwd=self.folder,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        if done.returncode:
            raise SystemExit(f"FAILED: no screenshot of {name}: {done.stderr}")
        return read_ppm(path)

    def render(self, *options):
        """Runs cbvh_render with a small picture."""
        done = subprocess.run(
            [self.renderer, *options, "--size", "16x16", "--output", os.path.join(self.folder, "rendered")],
            env=self.environment,
            cwd=self.folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        if done.returncode:
            raise SystemExit(f"FAILED: cbvh_render {' '.join(options)}: {done.stderr}")

    def read(self, name):
        with open(os.path.join(self.folder, name)) as file:
            return file.read()

    def start(self, *options, scene=("--scene", "cube"), size=SIZE):
        folder = Path(self.folder)
        with open(folder / "log", "w") as log, open(folder / "output", "w") as output:
            self.viewer = subprocess.Popen(
                [self.program, *scene, "--size", "%dx%d" % size, *options],
                env=self.environment,
                cwd=self.folder,
                stdout=output,
                stderr=log,
            )

        def window():
            if self.viewer.poll() is not None:
                raise SystemExit(f"FAILED: the viewer ended with status {self.viewer.returncode}: {self.read('log')}")
            return self.xdotool("search", "--onlyvisible", "--name", "cbvh_viewer").split("\n")[0]

        self.window = wait_for("no window", window)
        self.move_cursor_out()

        def focused():  # without a window manager
            self.xdotool("windowfocus", self.window)
            return self.xdotool("getwindowfocus", "-f") == self.window

        wait_for("the window does not take the focus", focused)

    def key(self, *keys):
        for key in keys:
            self.xdotool("key", key)

    def move_cursor_out(self):
        """Moves the cursor, which is part of the screen, outside of the window."""
        self.xdotool("mousemove", 790, 590)

    def mouse(self, *steps):
        # With pauses: GLFW reads the current mouse position, not the position of the click.
        for step in steps:
            self.xdotool(*step)
            time.sleep(0.2)

    def drag(self, begin, end, button=1):
        self.mouse(("mousemove", *begin), ("mousedown", button), ("mousemove", *end), ("mouseup", button))
        self.move_cursor_out()

    def title(self):
        return self.xdotool("getwindowname", self.window)

    def says(self, what):
        """Waits until the title of the window contains a text."""
        wait_for(f"the title does not say '{what}'", lambda: what in self.title())
        print(f"says {what}")

    def camera(self):
        """Returns (eye, target) as printed by the window."""
        before = self.read("output")
        self.key("c")
        line = wait_for(
            "the camera is not printed",
            lambda: (lambda text: text != before and text.endswith("\n") and text)(self.read("output")),
        )
        numbers = [float(n) for n in line.split("\n")[-2].split()[1].split(",")]
        return numbers[:3], numbers[3:6]

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
