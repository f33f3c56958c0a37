# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Records of cbvh_bench as one flat table. Each row is one measurement: a speed with the errors of its view and the
memory of its representation; a view, a check or a representation without speeds; or an entry for something that was
skipped."""

import json
import re
from itertools import count

import pandas

import bench_records

OUTPUTS = re.compile(r" --(json|pictures|maps) ('[^']*'|\S+)")
CHECKS = {"shadows": "shadow", "crossings": "crossing", "hit_agreement": "agreement"}  # lists of a result
ERRORS = """median_pixels p99_pixels max_pixels rmse_pixels bias_pixels inlier_rmse_pixels rmse_along_ray_pixels
    normal_median_degrees flipped_normals uv_median_quads rays beyond_5_pixels false_hits misses""".split()
KINDS_OF_ERRORS = "errors errors_to_reference_level errors_to_true_surface bounced".split()
COLUMNS = """what origin job scene level representation kind isa device quads result speeds view_count folder command
    skipped frame_level view picture error_map ray_set query mode threads seconds build_seconds mrays_per_second_median
    mrays_per_second_min mrays_per_second_max relative_to_grid_median relative_to_grid_spread memory_live_bytes
    memory_compression_leaf_bytes memory_compression_node_bytes memory_compression_header_bytes
    memory_compression_fallback_quads memory_compression_quads on_device_device_bytes on_device_imported_bytes
    leaks_rays sheets_rays run_command run_cpu run_date run_end run_commit run_hardware_threads run_settings_repeat
    run_settings_true_surface_hits run_settings_reference_level""".split()
COLUMNS += [f"{kind}_{key}" for kind in KINDS_OF_ERRORS for key in ERRORS]  # columns exist even if no record has them


def flat(nested, prefix=""):
    """Flattens nested dictionaries: {"memory": {"live_bytes": 1}} becomes {"memory_live_bytes": 1}."""
    out = {}
    for key, value in nested.items():
        out.update(flat(value, f"{prefix}{key}_") if isinstance(value, dict) else {prefix + key: value})
    return out


def rows_of_result(result):
    """Returns dictionaries with the columns that a result adds to those of its run and group."""
    base = flat({key: value for key, value in result.items() if key not in ("views", "speed", *CHECKS)})
    if "skipped" in result:
        return [{**base, "what": "skipped"}]
    base.update(speeds=len(result["speed"]), view_count=len(result["views"]))
    views = {view["view"]: flat(view) for view in result["views"]}
    rows = [{**base, **views.get(speed["view"], {}), **flat(speed), "what": "speed"} for speed in result["speed"]]
    timed = {row["view"] for row in rows}
    rows += [{**base, **view, "what": "view"} for name, view in views.items() if name not in timed]
    for key, what in CHECKS.items():
        rows += [{**base, **flat(check, f"{what}_"), "what": what} for check in result.get(key, ())]
    return rows or [{**base, "what": "result"}]


def rows_of_record(record, job, numbers=count()):
    """Returns the rows of a record. `result` numbers are unique for each result."""
    run = {**flat(record["run"], "run_"), "command": OUTPUTS.sub("", record["run"]["command"]), "job": job}
    asked = record["run"].get("settings", {}).get("device", "cpu")
    rows = []
    for group in record["groups"]:
        shared = {**run, **{key: value for key, value in group.items() if not isinstance(value, list)}}
        for result in group["results"]:
            device = result.get("on_device", {}).get("device") or ("" if asked == "cpu" else asked)
            shared.update(device=device, result=next(numbers))
            rows += [{**shared, **row} for row in rows_of_result(result)]
    return rows


def read(path, origin):
    """Returns the rows of a record or of a folder of records, the runs, and a line for each record that cannot be read.
    The origin is "gpu" for measurements on a device and "gpu baseline" for the CPU measurements that they are compared
    with."""
    rows, runs, problems = [], [], []
    for file in sorted(path.glob("*.json")) if path.is_dir() else [path]:
        try:
            record = bench_records.read(file)
        except bench_records.Damaged as error:
            problems.append(f"{file.name}: {error}")
            continue
        runs.append(record["run"])
        job = file.stem.rsplit("_L", 1)[0]
        cpu_origin = "gpu baseline" if origin == "gpu" or job.startswith("gpu_") else origin
        for row in rows_of_record(record, job):
            row_origin = "gpu" if row["device"] else cpu_origin
            rows.append({**row, "origin": row_origin, "record": file.name, "folder": str(file.parent)})
    return rows, runs, problems


def as_table(rows):
    """Returns a pandas table with all columns of COLUMNS and of the rows."""
    return pandas.DataFrame(rows, columns=list(dict.fromkeys([*COLUMNS, *(name for row in rows for name in row)])))


def csv(table):
    """Returns the table as CSV. Lists are JSON. Leaves out empty columns and local folders."""
    out = table.drop(columns=["folder", "run_command"]).dropna(axis=1, how="all")
    for name in [name for name in out if out[name].map(lambda value: isinstance(value, list)).any()]:
        out[name] = out[name].map(json.dumps, na_action="ignore")
    return out.to_csv(index=False)
