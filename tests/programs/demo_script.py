# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests when scripts/demo.sh uses programs of a wheel or of Debian packages in output/, and when it builds.

    demo_script.py

The demo runs in a folder with a few sources. Stand-ins replace cbvh_render, cmake and apt-get.
"""

import os
import platform
import re
import shutil
import subprocess
import tempfile
import unittest
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WHEEL = f"embree_cbvh-0.9.0-cp311.cp313-cp311.cp313-manylinux_2_36_{platform.machine()}.whl"

# Starts only if {folder}/library exists, like a program that needs a library. Appends {name} to {folder}/calls.
RENDER = """#!/bin/sh
[ -e "{folder}/library" ] || {{ echo "libtbb.so.12: cannot open shared object file" >&2; exit 127; }}
[ "$1" != --version ] || exit 0
echo "{name} $*" >> "{folder}/calls"
while [ "$1" != --output ]; do shift; done
mkdir -p "$2" && : > "$2/picture.png"
"""
CMAKE = """#!/bin/sh
echo "cmake $*" >> "{folder}/calls"
case $* in *--build*)
  [ ! -e "{folder}/progress" ] || cat "{folder}/progress"
  mkdir -p build/demo/tutorials/render
  cp "{folder}/built" build/demo/tutorials/render/cbvh_render ;;
esac
"""
APT = """#!/bin/sh
case $* in *satisfy*)
  echo "apt-get satisfy" "$(echo "${{*#*satisfy }}" | tr -s ' ,')" >> "{folder}/calls"
  [ ! -e "{folder}/mirror" ] || : > "{folder}/library" ;;
esac
"""


class Demo(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.tree = self.folder / "tree"
        (self.tree / "scripts/packaging").mkdir(parents=True)
        for name in ("demo.sh", "prebuilt.sh", "lib.sh", "packages", "packaging/sources.sh"):
            shutil.copy(ROOT / "scripts" / name, self.tree / "scripts" / name)
        for name in (
            "common/a.cpp",
            "include/a.h",
            "kernels/a.cpp",
            "tutorials/a.cpp",
            "docs/a.md",
            "CMakeLists.txt",
            "CMakePresets.json",
        ):
            path = self.tree / name
            path.parent.mkdir(exist_ok=True)
            path.write_text("1")
        self.output = self.tree / "output"
        self.output.mkdir()
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        for name, text in {"cmake": CMAKE, "apt-get": APT, "sudo": '#!/bin/sh\nexec "$@"\n'}.items():
            self.write_program(self.bin / name, text)
        self.write_program(self.folder / "built", RENDER, "built")
        (self.folder / "library").touch()

    def write_program(self, path, text, name=""):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.format(folder=self.folder, name=name))
        path.chmod(0o755)

    def hash(self):
        return subprocess.run(
            [self.tree / "scripts/packaging/sources.sh"], check=True, stdout=subprocess.PIPE, text=True
        ).stdout

    def add_wheel(self, name=WHEEL):
        with zipfile.ZipFile(self.output / name, "w") as wheel:
            wheel.writestr("embree_cbvh/bin/cbvh_render", RENDER.format(folder=self.folder, name="wheel"))
            wheel.writestr("embree_cbvh-0.9.0.dist-info/sources.sha256", self.hash())

    def add_package(self, name, depends, architecture=None):
        own = subprocess.run(["dpkg", "--print-architecture"], check=True, stdout=subprocess.PIPE, text=True).stdout
        architecture = architecture or own.strip()
        stage = self.folder / name
        documents = stage / "usr/share/doc" / name
        documents.mkdir(parents=True)
        (documents / "sources.sha256").write_text(self.hash())
        (stage / "usr/lib/triplet").mkdir(parents=True)
        self.write_program(stage / "usr/bin/cbvh_render", RENDER, "package in ${LD_LIBRARY_PATH##*/}")
        (stage / "DEBIAN").mkdir()
        (stage / "DEBIAN/control").write_text(
            f"Package: {name}\nVersion: 0.9.0\nArchitecture: {architecture}\nMaintainer: The authors <>\n"
            f"Depends: {depends}\nDescription: a stand-in\n"
        )
        subprocess.run(
            ["dpkg-deb", "--root-owner-group", "--build", stage, self.output / f"{name}_0.9.0_{architecture}.deb"],
            check=True,
            stdout=subprocess.DEVNULL,
        )

    def add_packages(self, **options):
        self.add_package("libembree3-cbvh", "libtbb12 (>= 2021)", **options)
        self.add_package(
            "embree-cbvh-tools", "libembree3-cbvh (= 0.9.0), libc6 (>= 2), libembree3-3 (>= 3.13)", **options
        )

    def run_demo(self, *words):
        """Returns the output of the demo. Sets `calls`: the programs that it started, in order, without options."""
        environment = dict(os.environ, PATH=f"{self.bin}:{os.environ['PATH']}")
        result = subprocess.run(
            [self.tree / "scripts/demo.sh", *words],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=100,
        )
        self.assertEqual(result.returncode, 0, result.stdout)
        calls = (self.folder / "calls").read_text().splitlines()
        (self.folder / "calls").unlink()
        self.calls = [call.partition(" --")[0] for call in calls]
        self.assertTrue((self.output / "demo/picture.png").exists())
        return result.stdout

    def assert_built(self, *words):
        output = self.run_demo("--short", *words)
        self.assertEqual(self.calls, ["cmake", "cmake", "built"], output)
        return output

    def test_nothing_prebuilt(self):
        output = self.run_demo()
        self.assertEqual(self.calls, ["cmake", "cmake"] + 3 * ["built"])
        self.assertEqual(len(re.findall("^output/(?!demo/)", output, re.MULTILINE)), 1, output)
        self.assertRegex(output, "output/ .*wheel.*packages")
        self.assertIn("build/demo/tutorials/render/cbvh_render\n", output)

    def test_wheel_of_these_sources(self):
        self.add_wheel()
        (self.tree / "docs/a.md").write_text("pages are not part of the programs")
        output = self.run_demo()
        self.assertEqual(self.calls, 3 * ["wheel"], output)
        self.assertRegex(output, f"output/{re.escape(WHEEL)} .*these sources")
        self.assertIn("build/prebuilt/cbvh_render\n", output)

    def test_wheel_of_other_sources(self):
        for name in ("kernels/a.cpp", "tutorials/b.cpp", "CMakeLists.txt"):
            with self.subTest(name):
                self.add_wheel()
                (self.tree / name).write_text("2")
                self.assertRegex(self.assert_built(), f"output/{re.escape(WHEEL)} .*other sources")

    def test_damaged_wheel(self):
        (self.output / WHEEL).write_text("not an archive")
        self.assertRegex(self.assert_built(), f"output/{re.escape(WHEEL)} .*unpacked")

    def test_wheel_that_does_not_start(self):
        (self.folder / "library").unlink()
        (self.folder / "built").write_text((self.folder / "built").read_text().replace("library", "built"))
        self.add_wheel()
        self.assertRegex(self.assert_built(), f"output/{re.escape(WHEEL)} .*cbvh_render .*: libtbb.so.12: cannot open")

    def test_packages_of_these_sources(self):
        self.add_packages()
        output = self.run_demo("--short")
        self.assertEqual(self.calls, ["package in triplet"], output)

    def test_packages_that_need_a_library(self):
        (self.folder / "library").unlink()
        (self.folder / "mirror").touch()
        self.add_packages()
        output = self.run_demo("--short")
        self.assertEqual(
            self.calls, ["apt-get satisfy libtbb12 (>= 2021), libc6 (>= 2), ", "package in triplet"], output
        )

    def test_library_of_other_sources(self):
        self.add_package("libembree3-cbvh", "libc6")
        (self.tree / "kernels/a.cpp").write_text("2")
        self.add_package("embree-cbvh-tools", "libc6")
        self.assertRegex(self.assert_built(), "output/embree-cbvh-tools_.* other sources")


if __name__ == "__main__":
    unittest.main()
