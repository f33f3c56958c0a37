# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Progress of a run of jobs, and an estimate of the remaining time."""

import shutil
import sys
import time


class Progress:
    """Shows a bar with the remaining time on a terminal, otherwise one line per job."""

    def __init__(self, expected):
        self.left = dict(expected)  # seconds by job, as planned
        self.total = sum(expected.values())
        self.planned = self.spent = 0.0  # of finished jobs
        self.terminal = sys.stdout.isatty()
        self.current, self.begin, self.step = None, 0.0, ""

    def start(self, job):
        self.current, self.begin, self.step = job, time.monotonic(), ""

    def finish(self):
        self.planned += self.left[self.current]
        self.spent += time.monotonic() - self.begin
        del self.left[self.current]
        self.current = None

    def slowdown(self):
        """Duration of the finished jobs on this machine as a multiple of the planned duration."""
        return (self.spent + 10) / (self.planned + 10)  # near 1 until jobs have taken longer than 10 seconds

    def draw(self):
        if not self.terminal or self.current is None:
            return
        slowdown, elapsed = self.slowdown(), time.monotonic() - self.begin
        expected_here = self.left[self.current] * slowdown
        counted = min(elapsed, 0.97 * expected_here)
        left = sum(self.left.values()) * slowdown - counted
        done = (self.planned + counted / slowdown) / max(self.total, 1e-9)
        width = 28
        filled = int(width * min(done, 1.0))
        bar = "#" * filled + "." * (width - filled)
        text = f"[{bar}] {100 * done:3.0f}%  {clock(left)} left  {self.current}: {self.step}"
        print("\r\033[K" + text[: shutil.get_terminal_size().columns - 1], end="", flush=True)

    def clear(self):
        print("\r\033[K" if self.terminal else "", end="", flush=True)

    def print_line(self, text):
        self.clear()
        print(text, flush=True)


def clock(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
