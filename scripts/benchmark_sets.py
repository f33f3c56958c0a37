# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The sets of scripts/benchmark.py: the jobs that each of them measures."""

import shlex
from dataclasses import dataclass


@dataclass
class Job:
    """One scene, measured by one process of cbvh_bench. The process writes one record for all levels."""

    name: str  # also the base name of its files
    figures: str  # figures that it provides data for; printed when the job is done
    scene: str  # value of --scene; empty if the options name a cage
    levels: list
    options: str
    seconds: float  # estimate for two cores
    heavy: bool = False  # may exceed the memory; it is skipped then instead of failing
    pictures: bool = True

    @property
    def arguments(self):
        return shlex.split(self.options)

    @property
    def needs_vulkan(self):
        """True for jobs on a Vulkan device and for their CPU counterparts, which serve only as a reference.
        scripts/report.py uses the same prefix: jobs with it appear only in the GPU section."""
        return self.name.startswith("gpu_")


# The paper's cLEAF is cleaf-only. The library's cleaf is added for comparisons of memory, as is naive-compact, which is
# naive in Embree's compact mode. Sets for Vulkan devices have naive alone, because these hold no tree of Embree.
MAIN = "naive,naive-compact,grid,cgrid^2,cvoxel^2,cvoxel^3,cvoxel^4,cleaf^2,cleaf-only^2,cleaf-only^3,cvert"
FINE_FRAMES = "grid,cgrid^2,cvoxel^2,cvoxel^3,cvoxel^4,cleaf^2,cleaf-only^2,cleaf-only^3,cleaf-only^4,cvert"
CLOSED = ("cube:0.001", "cube:0.03", "cube", "frog", "knee", "scythe", "trex")
ENTRANCES = "--query closest,any --mode single,packet4,packet8,packet16,stream --true-surface 0"


# A job reads best on few lines.
# fmt: off

def cube(views, measure, seconds):
    """Level 8 of the cube fits into memory, so errors are measured against it."""
    return [
        Job("cube", "figures 1 and 10, error", "cube", [4, 5, 6, 7, 8],
            f"--representation {FINE_FRAMES},naive,naive-compact --reference-level 8 --view {views} "
            f"--picture-level 6,8 {measure}", seconds),
        Job("cube_fivefold", "figure 18", "cube:0.45", [6],
            f"--representation grid,cvoxel^3,cleaf-only^3,cvert --view full {measure}", 4),
    ]


def portraits(measure, seconds):
    """Pictures and errors of the full and the close view."""
    return [Job(scene, f"figure {number}", scene, [6],
                f"--representation grid,cvoxel^3,cleaf-only^2,cvert --view full,close {measure}", seconds)
            for number, scene in ((13, "frog"), (14, "scythe"), (15, "knee"))]


def checks(scenes, level, rays, what, seconds):
    """Leaks from closed surfaces, and secondary rays that start at a representation's own hits."""
    return [Job("checks_" + scene.replace(":", "_"), "leaks and self-shadowing", scene, [level],
                f"--representation cgrid^2,cvoxel^3,cleaf-only^2,cvert --view full --size 1024x1024 --repeat 0 "
                f"--check {what} --check-rays {rays}", seconds)
            for scene in scenes]


def hard_checks(rays):
    """Levels 3 to 7, frame levels that differ between faces, and positions far from the origin."""
    options = f"--view full --size 64x64 --repeat 0 --true-surface 0 --check leaks --check-rays {rays}"
    mixed = "cgrid^2,cvoxel^auto,cleaf-only^2,cleaf-only^auto,cvert --max-error-diagonals 0.002"
    return [Job("checks_levels", "leaks, all levels", "cube", [3, 4, 5, 6, 7], f"--representation {mixed} {options}",
                200),
            Job("checks_far", "leaks, far away", "cube", [3, 4, 5],
                f"--representation {mixed} --position 148376,1234,-223423 {options}", 120)]


def sheets(rays, seconds):
    """Rays through random sheets. They do not depend on the scene."""
    return [Job("checks_sheets", "rays through random sheets", "knee", [3],
                "--representation grid,cgrid^1,cvoxel^1,cleaf-only^1,cvert --view full --size 64x64 --repeat 0 "
                f"--true-surface 0 --check sheets --check-rays {rays}", seconds)]


def gpu_pair(name, scene, levels, representations, device_rays, cpu_rays, seconds, heavy=False):
    """The same scenes and views on a Vulkan device and on one CPU thread. seconds: estimates for both."""
    options = f"--representation {representations} --view full --query closest,any --true-surface 0"
    return [Job(f"gpu_{name}", "speed and memory on a GPU", scene, levels, f"{options} --device vulkan {device_rays}",
                seconds[0], heavy, pictures=False),
            Job(f"gpu_{name}_cpu", "the same on the processor", scene, levels, f"{options} {cpu_rays}",
                seconds[1], heavy, pictures=False)]


GPU = "grid,cgrid^2,cvoxel^2,cvoxel^3,cleaf-only^2,cleaf-only^3,cvert"


def gpu():
    """For hardware devices, which need many rays per call: one ray per pixel, and one bounce per hit. llvmpipe takes
    half an hour per scene. NAIVE of trex is a separate job, because a job ends if the device's memory does not
    suffice."""
    rays = ("--size 1024x1024 --rays 0 --repeat 5", "--size 1024x1024 --rays 200000 --repeat 5")
    every = [4, 5, 6, 7]
    pairs = [gpu_pair(scene, scene, every, f"naive,{GPU}", *rays, seconds, heavy=True)
             for scene, seconds in (("cube", (60, 100)), ("knee", (60, 120)), ("frog", (120, 240)))]
    pairs += [gpu_pair("trex", "trex", every, GPU, *rays, (600, 600), heavy=True),
              gpu_pair("trex_naive", "trex", every, "naive", *rays, (700, 700), heavy=True)]
    return [job for pair in pairs for job in pair]


def gpu_quick():
    """For any device, including llvmpipe, for which the times are estimated."""
    rays = ("--size 256x256 --rays 0 --repeat 5",) * 2
    pairs = [gpu_pair(scene, scene, [4, 5], "naive,grid,cgrid^2,cvoxel^2,cleaf-only^2,cvert", *rays, seconds,
                      heavy=True)
             for scene, seconds in (("trex", (130, 40)), ("frog", (90, 20)), ("cube", (50, 12)), ("knee", (50, 12)))]
    return [job for pair in pairs for job in pair]


def quick():
    small = "--size 768x768 --true-surface 1000 --samples 4"
    return (
        cube("full", f"{small} --rays 30000 --repeat 9", 96)
        + [Job("trex", "figures 11, 12, 16, 17", "trex", [4, 5, 6],
               f"--representation {MAIN} --view full,close --picture-level 6 {small} --rays 50000 --repeat 9", 267)]
        + portraits(f"{small} --rays 50000 --repeat 5", 12)
        + [Job("entrances", "packets, streams, any hit", "trex", [4],
               f"--representation grid,cgrid^2,cvoxel^2,cleaf-only^2,cvert --view full {ENTRANCES} --size 768x768 "
               f"--rays 40000 --repeat 5",
               30)]
        + checks(["knee", "scythe"], 5, 200000, "leaks,shadows", 24)
        + sheets(200000, 2)
    )


def figures():
    measure = "--size 1024x1024 --rays 300000"
    return (
        cube("full,close", "--size 1024x1024 --rays 200000 --repeat 9", 227)
        + [Job("trex", "figures 11, 12, 16, 17", "trex", [4, 5, 6],
               f"--representation {MAIN},cgrid^3 --view full,close --picture-level 6 {measure} --repeat 9", 311),
           Job("trex_level8", "figure 11, right", "trex", [8],
               f"--representation grid,cvoxel^4 --view full,close {measure} --repeat 5", 300, heavy=True)]
        + portraits("--size 1024x1024 --rays 200000 --repeat 5", 20)
        + [Job("trex_levels", "error against speed and memory", "trex", [4, 5, 6],
               f"--representation {FINE_FRAMES} --reference-level 7 --view full {measure} --repeat 5", 198, heavy=True),
           Job("entrances", "packets, streams, any hit", "trex", [5],
               f"--representation grid,cgrid^2,cvoxel^2,cleaf-only^2,cvert --view full {ENTRANCES} --size 1024x1024 "
               f"--rays 100000 --repeat 7",
               80)]
    )


def paper():
    return figures() + checks(CLOSED, 6, 10**6, "leaks,shadows", 15) + sheets(10**6, 25)


def full(isas):
    measure = "--size 1024x1024 --rays 200000 --repeat 5"
    jobs = figures() + checks(CLOSED, 6, 10**7, "leaks,offsets", 120) + hard_checks(10**7) + sheets(10**7, 250) + [
        Job("trex_rough", "strong displacement", "trex:0.02", [5, 6],
            f"--representation {MAIN} --view full,close {measure}", 181),
        Job("threads", "all threads", "trex", [5],
            f"--representation naive,naive-compact,grid,cgrid^2,cvoxel^2,cleaf-only^2,cvert --view full "
            f"--mode single,stream --threads 1,0 {measure}", 70),
        Job("herd", "growth", "herd", [4, 5],
            f"--representation grid,cvoxel^2,cleaf-only^2,cvert --view full {measure}", 120, heavy=True),
    ]
    jobs += frames("--size 1024x1024 --rays 100000 --repeat 5")
    if len(isas) > 1:
        jobs.append(Job("isas", "instruction sets", "trex", [5],
                        f"--representation naive,naive-compact,grid,cgrid^2,cvoxel^2,cleaf-only^2,cvert "
                        f"--isa {','.join(isas)} --view full {measure}", 210))
    return jobs + gpu_quick()


def frames(measure):
    """Bytes and speed over levels and frame levels. Levels that exceed the memory are skipped: level 8 of trex requires
    16 GiB in GRID alone."""
    options = "--representation grid,cgrid,cvoxel,cleaf-only,cvert --frame-level 1,2,3,4 --view full --true-surface 0 "
    options += measure
    return [Job(f"frames_{scene}", "levels and frame levels", scene, [4, 5, 6, 7, 8], options, seconds,
                heavy=True, pictures=False)
            for scene, seconds in (("cube", 90), ("trex", 900))]


# Estimated seconds for a user's cage on two cores: rays and pictures per level, and builds per million quads.
OWN_SECONDS_PER_LEVEL = 58
OWN_SECONDS_PER_MILLION_QUADS = 24


def own_cage(name, options, levels, faces):
    """The job for a cage of the user. faces: see faces_of in benchmark.py, for the estimate."""
    quads = faces * sum(4**level for level in levels)
    seconds = OWN_SECONDS_PER_LEVEL * len(levels) + OWN_SECONDS_PER_MILLION_QUADS * 1e-6 * quads
    words = f"--representation {FINE_FRAMES},naive,naive-compact --view full,close {options}"
    return Job(name, "your cage", "", levels, words, seconds, heavy=True)


ISAS = ("sse2", "sse4.2", "avx", "avx2", "avx512")
NAMES = ("quick", "full", "paper", "gpu", "gpu-quick")


def jobs_of(name, isas):
    return {"quick": quick, "paper": paper, "full": lambda: full(isas), "gpu": gpu, "gpu-quick": gpu_quick}[name]()


def scenes_of(name):
    """Names of the scenes of a set, in the order of its jobs."""
    return list(dict.fromkeys(job.scene.split(":")[0] for job in jobs_of(name, ISAS)))
