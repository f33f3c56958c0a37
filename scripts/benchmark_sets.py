# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The named sets of scripts/benchmark.py: what is measured for which figure."""

from dataclasses import dataclass, field


@dataclass
class Job:
    """One scene in one process of cbvh_bench; a record a level."""

    name: str             # of its files
    figures: str          # what it is for, shown while it runs
    scene: str            # as --scene takes it; empty: arguments name a cage
    levels: list
    arguments: list = field(default_factory=list)
    seconds: float = 10   # on two cores, for the first estimate of the time left
    heavy: bool = False   # may not fit into memory: then left out, not failed


TRIANGLES_TO_LEAVES = "naive,grid,cgrid^2,cvoxel^2,cvoxel^3,cleaf^2,cleaf^3"
WITH_FINE_FRAMES = "grid,cvoxel^2,cvoxel^3,cvoxel^4,cleaf^2,cleaf^3,cleaf^4"


def portrait(name, figures, scene, seconds=20, rays=100000):
    """A scene of figures 13 to 15: pictures and errors, full and close."""
    return Job(name, figures, scene, [6], [
        "--view", "full,close", "--representation", "grid,cvoxel^3,cleaf^2", "--size", "768x768",
        "--rays", str(rays), "--repeat", "3"], seconds)


def cube(views, rays, repeat, size="768x768", seconds=30):
    return [
        Job("cube", "figures 1 and 10, error", "cube", [4, 5, 6, 7, 8], [
            "--view", views, "--representation", WITH_FINE_FRAMES + ",naive,cgrid^2", "--reference-level", "8",
            "--rays", str(rays), "--repeat", str(repeat), "--size", size], seconds),
        Job("cube_fivefold", "figure 18", "cube:0.45", [6], [
            "--view", "full", "--representation", "grid,cvoxel^3,cleaf^3", "--rays", str(rays),
            "--repeat", str(repeat), "--size", size], 5)]


def quick():
    return cube("full", 30000, 4) + [
        Job("trex", "figures 11, 12, 16, 17", "trex", [4, 5, 6], [
            "--view", "full,close", "--representation", TRIANGLES_TO_LEAVES + ",cvoxel^4", "--size", "768x768",
            "--rays", "60000", "--repeat", "5"], 130),
        portrait("frog", "figure 13", "frog", 15, 50000),
        portrait("scythe", "figure 14", "scythe", 15, 50000),
        portrait("knee", "figure 15", "knee", 15, 50000),
        Job("entrances", "packets and streams", "trex", [4], [
            "--view", "full", "--representation", "grid,cgrid^2,cvoxel^2,cleaf^2", "--size", "768x768",
            "--query", "closest,any", "--mode", "single,packet4,packet8,packet16,stream",
            "--rays", "40000", "--repeat", "3"], 30)]


def paper():
    return cube("full,close", 200000, 9, "1024x1024", 120) + [
        Job("trex", "figures 11, 12, 16, 17", "trex", [4, 5, 6], [
            "--view", "full,close", "--representation", TRIANGLES_TO_LEAVES + ",cgrid^3,cvoxel^4", "--size", "1024x1024",
            "--rays", "300000", "--repeat", "9"], 400),
        Job("trex_level8", "figure 11, right", "trex", [8], [
            "--view", "full,close", "--representation", "grid,cvoxel^4", "--size", "1024x1024",
            "--rays", "300000", "--repeat", "5"], 300, heavy=True),
        portrait("frog", "figure 13", "frog", 40, 200000),
        portrait("scythe", "figure 14", "scythe", 40, 200000),
        portrait("knee", "figure 15", "knee", 40, 200000)]


def full(isas=()):
    jobs = paper() + [
        Job("trex_levels", "error against memory", "trex", [4, 5, 6], [
            "--view", "full,close", "--representation", WITH_FINE_FRAMES + ",cgrid^2", "--reference-level", "7",
            "--size", "1024x1024", "--rays", "200000", "--repeat", "5"], 400, heavy=True),
        Job("trex_rough", "strong displacement", "trex:0.02", [5, 6], [
            "--view", "full,close", "--representation", TRIANGLES_TO_LEAVES, "--size", "1024x1024",
            "--rays", "200000", "--repeat", "5"], 240),
        Job("entrances", "packets and streams, all threads", "trex", [5], [
            "--view", "full,close", "--representation", "naive,grid,cgrid^2,cvoxel^2,cleaf^2", "--size", "1024x1024",
            "--query", "closest,any", "--mode", "single,packet4,packet8,packet16,stream", "--threads", "1,0",
            "--rays", "200000", "--repeat", "5"], 500),
        Job("herd", "growth", "herd", [4, 5], [
            "--view", "full", "--representation", "grid,cvoxel^2,cleaf^2", "--rays", "200000", "--repeat", "5"],
            300, heavy=True)]
    if len(isas) > 1:
        jobs.append(Job("isas", "instruction sets", "trex", [5], [
            "--view", "full", "--representation", "naive,grid,cgrid^2,cvoxel^2,cleaf^2", "--isa", ",".join(isas),
            "--rays", "200000", "--repeat", "5"], 400))
    return jobs


NAMES = ("quick", "full", "paper")


def jobs_of(name, isas):
    return {"quick": quick, "paper": paper, "full": lambda: full(isas)}[name]()
