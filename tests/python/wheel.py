#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""The wheel of scripts/wheel.sh works in a new virtual environment.

    wheel.py FOLDER VERSION    FOLDER has a wheel of this version for the interpreter; otherwise the test is skipped

Outside of the build tree and without its environment: pip installs the wheel; wheel_in_use.py traces, saves and loads,
also if another Embree is in the process; a program renders. Only libraries of the wheel and of the system are loaded.
"""

import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77
ENVIRONMENT = {"PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"}
sys.path.insert(0, str(ROOT / "scripts/packaging"))


def run(*command, folder, **options):
    result = subprocess.run(
        command,
        cwd=folder,
        env=dict(ENVIRONMENT, HOME=folder),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        check=False,
        **options,
    )
    if result.returncode:
        sys.exit(f"FAILED: {' '.join(map(str, command))}\n{result.stdout}")
    return result.stdout


def check_libraries(package):
    """ldd finds libraries in the wheel, or in the C and C++ runtime of every system."""
    import wheel_check

    binaries = wheel_check.binaries_in(package)
    assert len(binaries) > 4, binaries
    for binary in binaries:
        for line in run("ldd", binary, folder=package).splitlines():
            name, arrow, file = line.strip().partition(" => ")
            if not arrow or name in wheel_check.SYSTEM_LIBRARIES:
                continue
            assert pathlib.Path(file.partition(" (")[0]).resolve().parent == package / "lib", f"{binary}: {line}"


def main():
    folder, version = str(pathlib.Path(sys.argv[1]).resolve()), sys.argv[2]
    interpreter = f"cp{sys.version_info.major}{sys.version_info.minor}"
    # embree_cbvh-0.9.0-cp311.cp313.cp314-cp311.cp313.cp314-manylinux_2_36_x86_64.whl
    wheels = [
        wheel
        for wheel in sorted(pathlib.Path(folder).glob(f"embree_cbvh-{version}-*.whl"))
        if interpreter in wheel.name.split("-")[2].split(".")
    ]
    if not wheels:
        print(f"skipped: no wheel embree_cbvh-{version} for {interpreter} in {folder}, see scripts/wheel.sh")
        sys.exit(SKIPPED)
    check = ROOT / "scripts/packaging/wheel_check.py"
    with tempfile.TemporaryDirectory() as work:
        work = str(pathlib.Path(work).resolve())
        for wheel in wheels:
            print(run(sys.executable, "-B", check, wheel, folder=work), end="")
        # NumPy is the system's. The module must be the one of the wheel.
        run(sys.executable, "-m", "venv", "--system-site-packages", "environment", folder=work)
        environment = pathlib.Path(work, "environment")
        python = environment / "bin/python"
        run(
            python,
            "-m",
            "pip",
            "install",
            "--no-index",
            "--no-deps",
            "--find-links",
            folder,
            f"embree-cbvh=={version}",
            folder=work,
        )
        shown = run(python, "-m", "pip", "show", "embree-cbvh", folder=work)
        assert "License: Apache-2.0\n" in shown and "Requires: numpy\n" in shown, shown
        package = next(environment.glob("lib/python3.*/site-packages/embree_cbvh"))
        check_libraries(package)
        use = pathlib.Path(__file__).with_name("wheel_in_use.py")
        for order in ([], ["before"], ["after"]):
            others = ["libembree3.so.3", "libembree4.so.4"] if order else []
            print(run(python, "-B", use, package, version, *order, *others, folder=work), end="")

        for program in ("cbvh_render", "cbvh_pathtracer", "cbvh_terrain"):
            assert "--help" in run(environment / "bin" / program, "--help", folder=work)
        shown = run(environment / "bin/cbvh_render", "--version", folder=work)
        library = pathlib.Path(shown.strip().rpartition(", ")[2]).resolve()
        assert version in shown and library.parent == package / "lib", shown
        assert library.name.startswith("libembree_cbvh-"), shown
        run(
            environment / "bin/cbvh_render",
            "--scene",
            "cube",
            "--level",
            "3",
            "--size",
            "64x48",
            "--exr",
            "--output",
            "pictures",
            folder=work,
        )
        pictures = sorted(path.suffix for path in pathlib.Path(work, "pictures").iterdir())
        assert ".png" in pictures and ".exr" in pictures, pictures
        run(python, "-m", "pip", "uninstall", "-y", "embree-cbvh", folder=work)
        left = [path for path in environment.rglob("*cbvh*") if "__pycache__" not in path.parts]
        assert not left, f"left after the removal: {left}"
    print("the wheel installs, traces, renders and is removed")


if __name__ == "__main__":
    main()
