#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Assembles a Python wheel from a build of the preset `wheel`, see scripts/wheel.sh.

    wheel.py BUILD-DIRECTORY LIBRARIES-DIRECTORY OUTPUT-DIRECTORY

Requires Debian, patchelf, readelf, nm and strip. LIBRARIES-DIRECTORY is that of wheel_libraries.sh. The wheel contains

    embree_cbvh/__init__.*.so   the module, once per version of CPython
    embree_cbvh/__init__.pyi    its type stubs, and py.typed, which type checkers look for
    embree_cbvh/trimesh_rays.py a ray engine for trimesh
    embree_cbvh/lib/            libembree_cbvh, libembree3_vulkan, and the libraries that they need
    embree_cbvh/bin/            the programs; scripts of the same names start them
    embree_cbvh/include/cbvh/   headers of libembree_cbvh

Libraries get file names with a hash of their contents, as by `auditwheel repair`: otherwise the dynamic linker could
take another library of the same name that the process has loaded.
"""

import argparse
import base64
import hashlib
import itertools
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

import wheel_check

TAG = "2_36"  # of Debian 12's glibc
PROGRAMS = ["cbvh_render", "cbvh_pathtracer", "cbvh_terrain"]
# A header of each installed package that is compiled into the module, the programs and OpenImageIO.
HEADERS = ["CLI/CLI.hpp", "nlohmann/json.hpp", "volk.h", "tsl/robin_map.h", "fmt/core.h", "boost/version.hpp"]
ROOT = Path(__file__).resolve().parents[2]

# Importing embree_cbvh would load the library twice, so the script only looks for its folder.
SCRIPT = """#!python
import importlib.util
import os
import sys

folder = importlib.util.find_spec("embree_cbvh").submodule_search_locations[0]
os.execv(os.path.join(folder, "bin", "{name}"), ["{name}", *sys.argv[1:]])
"""

METADATA = """Metadata-Version: 2.1
Name: embree-cbvh
Version: {version}
Summary: Ray tracing of displaced subdivision surfaces and meshes that stay compressed in memory
Author: The Embree CBVH authors
License: Apache-2.0
Classifier: License :: OSI Approved :: Apache Software License
Classifier: Operating System :: POSIX :: Linux
{classifiers}
Classifier: Topic :: Multimedia :: Graphics :: 3D Rendering
Requires-Python: >={oldest}
Requires-Dist: numpy
Description-Content-Type: text/markdown

{readme}"""


def run(*command):
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False)
    if result.returncode:
        sys.exit(f"{' '.join(map(str, command))} failed: {result.stdout}")
    return result.stdout


def read_cache(build):
    text = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    return dict(re.findall(r"^([^#/:\n]+):[A-Z]+=(.*)$", text, re.M))


def copy_binary(source, target):
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)
    target.chmod(0o755)
    run("strip", "--strip-unneeded", target)
    return target


# --- libraries ------------------------------------------------------------------------------


def resolve(path):
    """Files of all libraries that a program or library of the build loads, by soname."""
    found = {}
    for name, file in re.findall(r"^\s*(\S+) => (.*?)(?: \(0x[0-9a-f]+\))?$", run("ldd", path), re.M):
        if file == "not found":
            sys.exit(f"{path} needs {name}, which was not found")
        found[name] = Path(file)
    return found


def collect_libraries(originals, folder):
    """Copies what the binaries need beyond the system's libraries. Returns copies and their originals by soname."""
    copies, sources = {}, {}
    for original in originals:
        for name, file in resolve(original).items():
            if name not in wheel_check.SYSTEM_LIBRARIES and name not in copies:
                copies[name] = copy_binary(file, folder / name)
                sources[name] = file.resolve()
    return copies, sources


def rename_libraries(copies, binaries):
    """Adds hashes to the file names, and lets all binaries of the wheel refer to these."""
    names = {}
    for name, path in copies.items():
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:8]
        stem, dot, rest = name.partition(".so")
        names[name] = f"{stem}-{digest}{dot}{rest}"
    libraries = [path.rename(path.with_name(names[name])) for name, path in copies.items()]
    folder = libraries[0].parent
    for path in [*binaries, *libraries]:
        search = os.path.relpath(folder, path.parent)
        needed = [name for name in wheel_check.read_binary(path).needed if name in names]
        # patchelf 0.14 mixes up the names if one run changes several entries.
        if path in libraries:
            run("patchelf", "--set-soname", path.name, path)
        for name in needed:
            run("patchelf", "--replace-needed", name, names[name], path)
        run("patchelf", "--set-rpath", "$ORIGIN" if search == "." else f"$ORIGIN/{search}", path)


# --- licenses -------------------------------------------------------------------------------


def package_of(file):
    """Name of the Debian package that installed a file. dpkg may know it by its path before /lib became a link."""
    for path in (file, Path("/", *file.parts[2:])):
        result = subprocess.run(
            ["dpkg-query", "-S", path], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, encoding="utf-8", check=False
        )
        if result.returncode == 0:
            return result.stdout.partition(":")[0]
    sys.exit(f"{file}: no package installed this library, so its license is unknown")


def copy_licenses(sources, libraries, folder):
    folder.mkdir(parents=True)
    shutil.copyfile(ROOT / "LICENSE", folder / "LICENSE")
    ours = {"embree": ROOT / "scripts/packaging/copyright"}
    for package, names in {"openimageio": ["LICENSE.md", "THIRD-PARTY.md"], "tiff": ["LICENSE.md"]}.items():
        for name in names:
            ours[f"{package}-{name}"] = libraries / package / name
    ours["pybind11-dev"] = libraries / "trixie/usr/share/doc/pybind11-dev/copyright"
    built = {ROOT, libraries.resolve()}
    files = {file for file in sources.values() if not built & set(file.parents)}
    files |= {Path("/usr/include", header) for header in HEADERS}
    for package in sorted(map(package_of, files)):
        ours[package] = Path("/usr/share/doc", package, "copyright")
    common = set()
    for name, source in ours.items():
        text = source.read_text(encoding="utf-8")
        common |= set(re.findall(r"/usr/share/common-licenses/([\w.+-]*\w)", text))
        (folder / f"{name}.txt").write_text(text, encoding="utf-8")
    for name in sorted(common):  # texts that Debian's files refer to
        text = Path("/usr/share/common-licenses", name).read_text(encoding="utf-8")
        (folder / f"common-licenses-{name}.txt").write_text(text, encoding="utf-8")


# --- wheel ----------------------------------------------------------------------------------


def find_modules(build, headers):
    """The modules of a build by the version of CPython, such as (3, 13), in ascending order."""
    modules = {}
    for path in (build / "tutorials/python").glob("embree_cbvh.cpython-*.so"):
        major, minor = re.match(r"embree_cbvh\.cpython-(\d)(\d+)-", path.name).groups()
        modules[int(major), int(minor)] = path
    expected = 1 + len(headers)
    if len(modules) != expected:
        sys.exit(f"{build}/tutorials/python has {len(modules)} modules: expected {expected}, see scripts/wheel.sh")
    return dict(sorted(modules.items()))


def write_metadata(folder, version, pythons, tag):
    classifiers = "\n".join(f"Classifier: Programming Language :: Python :: {python}" for python in pythons)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text = METADATA.format(version=version, classifiers=classifiers, oldest=pythons[0], readme=readme)
    (folder / "METADATA").write_text(text, encoding="utf-8")
    # The name of a wheel abbreviates tags; this file lists them.
    tags = "".join(f"Tag: {'-'.join(parts)}\n" for parts in itertools.product(*(part.split(".") for part in tag)))
    (folder / "WHEEL").write_text(
        f"Wheel-Version: 1.0\nGenerator: embree-cbvh\nRoot-Is-Purelib: false\n{tags}", encoding="utf-8"
    )


def write_wheel(stage, info, wheel):
    record = []
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:

        def add(name, data, mode):
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))  # the same bytes for the same contents
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100000 | mode) << 16
            archive.writestr(entry, data)

        for path in sorted(path for path in stage.rglob("*") if path.is_file()):
            name, data = path.relative_to(stage).as_posix(), path.read_bytes()
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}\n")
            add(name, data, 0o755 if os.access(path, os.X_OK) else 0o644)
        record.append(f"{info}/RECORD,,\n")
        add(f"{info}/RECORD", "".join(record), 0o644)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="build folder of the preset wheel")
    parser.add_argument("libraries", type=Path, help="folder that wheel_libraries.sh filled")
    parser.add_argument("output", type=Path, help="folder that receives the wheel")
    arguments = parser.parse_args()
    build, libraries = arguments.build.resolve(), arguments.libraries.resolve()

    cache = read_cache(build)
    version = cache["CMAKE_PROJECT_VERSION"]
    modules = find_modules(build, list(filter(None, cache.get("CBVH_PYTHON_HEADERS", "").split(";"))))
    platform = sysconfig.get_platform().replace("linux-", f"manylinux_{TAG}_")
    interpreters = ".".join(f"cp{major}{minor}" for major, minor in modules)
    tag = interpreters, interpreters, platform
    wheel = arguments.output / f"embree_cbvh-{version}-{'-'.join(tag)}.whl"
    info = f"embree_cbvh-{version}.dist-info"

    with tempfile.TemporaryDirectory() as temporary:
        stage = Path(temporary)
        package = stage / "embree_cbvh"
        originals = {path: package / path.name.replace("embree_cbvh.", "__init__.", 1) for path in modules.values()}
        for program in PROGRAMS:
            originals[build / "tutorials" / program.partition("_")[2] / program] = package / "bin" / program
            script = stage / f"embree_cbvh-{version}.data" / "scripts" / program
            script.parent.mkdir(parents=True, exist_ok=True)
            script.write_text(SCRIPT.format(name=program), encoding="utf-8")
            script.chmod(0o755)
        binaries = [copy_binary(*pair) for pair in originals.items()]
        copies, sources = collect_libraries(originals, package / "lib")
        rename_libraries(copies, binaries)
        shutil.copytree(ROOT / "include/cbvh", package / "include/cbvh")
        shutil.copyfile(ROOT / "tutorials/python/trimesh_rays.py", package / "trimesh_rays.py")
        shutil.copyfile(ROOT / "tutorials/python/embree_cbvh.pyi", package / "__init__.pyi")
        (package / "py.typed").touch()  # the package has type stubs
        copy_licenses(sources, libraries, stage / info / "licenses")
        write_metadata(stage / info, version, [f"{major}.{minor}" for major, minor in modules], tag)
        shutil.copyfile(build / "sources.sha256", stage / info / "sources.sha256")  # for scripts/prebuilt.sh

        problems, _ = wheel_check.problems_of(stage, interpreters.split("."), wheel_check.NEWEST[TAG])
        if problems:
            sys.exit("\n".join(f"{path}: {text}" for path, text in problems))
        arguments.output.mkdir(parents=True, exist_ok=True)
        for earlier in arguments.output.glob("embree_cbvh-*.whl"):
            earlier.unlink()
        write_wheel(stage, info, wheel)
    print(f"{wheel}: {os.path.getsize(wheel) / 2**20:.1f} MiB, with {len(copies)} libraries")


if __name__ == "__main__":
    main()
