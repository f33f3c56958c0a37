# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests that the build's ccache returns the precompiled header of the current headers, also if only a comment or an
unused macro differs from a version that it has.

  precompiled_headers.py LAUNCHER... COMPILER
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

VERSIONS = ("// A comment.", "// Not the same.", "#define VALUE 1", "#define VALUE 2", "// A comment.")


def main():
    command = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, CCACHE_DIR=folder + "/cache")

        def compile_with_cache(*options):
            subprocess.run(
                command + ["-fpch-preprocess", "-MD", "-MF", "dependencies", *options],
                cwd=folder,
                env=environment,
                check=True,
            )

        built = Path(folder, "built")
        for version in VERSIONS:
            Path(folder, "type.h").write_text(f"#pragma once\n{version}\nstruct Type {{}};\n", encoding="utf-8")
            Path(folder, "all.h").write_text('#include "type.h"\n', encoding="utf-8")
            value = f"static_assert(VALUE == {version[-1]});" if "VALUE" in version else ""
            Path(folder, "source.cpp").write_text(f'#include "type.h"\nType t;\n{value}\n', encoding="utf-8")
            shutil.rmtree(built, ignore_errors=True)  # as in a fresh clone
            built.mkdir()
            shutil.copy(Path(folder, "all.h"), built)
            compile_with_cache("-I.", "-x", "c++-header", "-c", "all.h", "-o", "built/all.h.gch")
            compile_with_cache(
                "-I.", "-include", "built/all.h", "-Winvalid-pch", "-Werror", "-c", "source.cpp", "-o", "source.o"
            )


if __name__ == "__main__":
    main()
