#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Long calls report progress, let other threads run, and can be stopped."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

import embree_cbvh as cbvh
from sheets import bumpy_model, rays_from_above

LONG = {"representation": "cleaf", "level": 7}  # of the model below: takes seconds


def long_model():
    return bumpy_model(40)


class Progress(unittest.TestCase):
    def test_phases_start_at_0_rise_and_end_at_1(self):
        reported, threads = {}, set()

        def progress(phase, fraction):
            reported.setdefault(phase, []).append(fraction)
            threads.add(threading.get_ident())

        cbvh.build(bumpy_model(), "naive", 5, progress=progress)
        self.assertEqual(list(reported), ["NAIVE: tessellation", "NAIVE: build"])
        for fractions in reported.values():
            self.assertEqual((fractions[0], fractions[-1]), (0, 1))
            self.assertEqual(fractions, sorted(set(fractions)))
        self.assertEqual(threads, {threading.get_ident()})

    def test_nothing_is_printed(self):
        code = "import embree_cbvh as c; c.build(c.Model.generate('cube'), 'cvert', 4)"
        done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=True)
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_exceptions_in_progress_stop_the_build(self):
        last = []

        def progress(_, fraction):
            last.append(fraction)
            if fraction > 0:
                raise LookupError("enough")

        with self.assertRaisesRegex(LookupError, "enough"):
            cbvh.build(long_model(), **LONG, progress=progress)
        self.assertLess(last[-1], 1)
        self.works()

    def test_progress_must_not_build(self):
        with self.assertRaisesRegex(RuntimeError, "progress"):
            cbvh.build(bumpy_model(), level=4, progress=lambda *_: cbvh.build(bumpy_model(), level=3))
        self.works()

    def test_calls_work_after_a_refused_thread(self):
        code = """
import resource
import embree_cbvh as cbvh
cage = cbvh.Cage([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
pages = int(open("/proc/self/statm").read().split()[0])
soft, hard = resource.getrlimit(resource.RLIMIT_AS)
resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + (1 << 20), hard)) # less than a stack
try:
    cbvh.build(cage, "cvert", 2)
except RuntimeError:
    print("refused")
resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
print(cbvh.build(cage, "cvert", 2).level)
"""
        done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("refused\n2\n", ""))

    def works(self):
        hits = cbvh.build(bumpy_model(), "cvert", 4).intersect(*rays_from_above())
        self.assertTrue(hits.hit.all())


class Interrupts(unittest.TestCase):
    def interrupt(self, call):
        """Calls call(started), and sends SIGINT shortly after it has called started()."""
        started = threading.Event()

        def press():
            started.wait()
            time.sleep(0.05)
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=press)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            call(started.set)
            time.sleep(10)  # a late signal must not end another test
        thread.join()

    def test_ctrl_c_stops_a_build(self):
        model, last = long_model(), []

        def progress(started):
            def report(_, fraction):
                last.append(fraction)
                started()

            return report

        self.interrupt(lambda started: cbvh.build(model, **LONG, progress=progress(started)))
        self.assertLess(last[-1], 1)
        self.assertTrue(cbvh.build(bumpy_model(), "grid", 3).intersect(*rays_from_above()).hit.all())

    def test_ctrl_c_stops_tracing(self):
        scene = cbvh.build(bumpy_model(), "grid", 5)
        rays = rays_from_above(256)
        finished = []

        def trace(started):
            started()
            scene.trace_seconds(*rays, passes=2000)
            finished.append(True)

        self.interrupt(trace)
        self.assertEqual(finished, [])


class Threads(unittest.TestCase):
    def test_other_threads_run_during_a_build(self):
        ticks, done = [], threading.Event()

        def tick():
            while not done.wait(0.005):
                ticks.append(time.monotonic())

        thread = threading.Thread(target=tick)
        thread.start()
        begin = time.monotonic()
        cbvh.build(long_model(), "cvert", 6)
        end = time.monotonic()
        done.set()
        thread.join()
        middle = [t for t in ticks if begin + 0.25 * (end - begin) < t < end - 0.25 * (end - begin)]
        self.assertGreater(len(middle), 0)

    def test_queries_of_other_threads_run_during_a_query(self):
        """An endless query of the main thread is interrupted once those of other threads have returned."""
        scenes = [cbvh.build(bumpy_model(), "ctile", 5), cbvh.build(bumpy_model(), "grid", 4)]
        rays = rays_from_above(256)

        def queries(scene):
            results = [scene.intersect(*rays).t, scene.occluded(*rays), scene.intersect(*rays, threads=1).t]
            if scene is scenes[0]:
                positions, hits = scene.closest_points(rays[0])
                results += [positions, hits.t]
            return [result.tobytes() for result in results]

        expected = [queries(scene) for scene in scenes]
        found = {}

        def work(number):
            found[number] = queries(scenes[number % 2])

        def work_and_press():
            workers = [threading.Thread(target=work, args=(number,)) for number in range(6)]
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.join()
            os.kill(os.getpid(), signal.SIGINT)

        interval = sys.getswitchinterval()
        self.addCleanup(sys.setswitchinterval, interval)
        sys.setswitchinterval(1000)  # other threads run only once the main thread waits in its query
        thread = threading.Thread(target=work_and_press)
        with self.assertRaises(KeyboardInterrupt):
            thread.start()
            scenes[0].trace_seconds(*rays, passes=2**31)
        sys.setswitchinterval(interval)
        thread.join()
        self.assertEqual(found, {number: expected[number % 2] for number in range(6)})

    def test_queries_run_during_a_build(self):
        scene, rays = cbvh.build(bumpy_model(), "ctile", 5), rays_from_above()
        expected, found = scene.intersect(*rays).t, []

        def progress(*_):
            found.append(scene.intersect(*rays).t)

        cbvh.build(bumpy_model(), "cvert", 5, progress=progress)
        self.assertGreater(len(found), 0)
        for t in found:
            np.testing.assert_array_equal(t, expected)

    def test_several_threads_build_and_trace(self):
        model, rays = bumpy_model(), rays_from_above()
        expected = {name: cbvh.build(model, name, 5).intersect(*rays).t for name in ("grid", "cvert", "cleaf")}
        found, phases = {}, {}

        def work(name):
            reported = phases.setdefault(name, set())
            for _ in range(3):
                scene = cbvh.build(model, name, 5, progress=lambda phase, _: reported.add(phase))
                found[name] = scene.intersect(*rays).t

        threads = [threading.Thread(target=work, args=(name,)) for name in expected]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for name, t in expected.items():
            np.testing.assert_array_equal(found[name], t)
        self.assertEqual(phases, {"grid": {"GRID: build"}, "cvert": {"cVERT: build"}, "cleaf": {"cLEAF: build"}})

    def test_program_ends_while_daemon_threads_build_and_trace(self):
        program = """
import sys, threading, time
sys.path.insert(0, %r)
import embree_cbvh as cbvh
from sheets import bumpy_model, rays_from_above
model, rays = bumpy_model(40), rays_from_above()
begun = threading.Barrier(4)
def work():
    begun.wait()
    while True:
        cbvh.build(model, "cvert", 6).intersect(*rays)
for _ in range(3):
    threading.Thread(target=work, daemon=True).start()
begun.wait()
time.sleep(float(sys.argv[1]))
""" % os.path.dirname(
            os.path.abspath(__file__)
        )
        for seconds in ("0", "0.02", "0.3"):
            done = subprocess.run(
                [sys.executable, "-B", "-c", program, seconds], capture_output=True, text=True, timeout=120
            )
            self.assertEqual((done.returncode, done.stderr), (0, ""), seconds)


if __name__ == "__main__":
    unittest.main()
