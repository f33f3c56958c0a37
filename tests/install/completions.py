#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks the completion scripts that scripts/packaging/completions.py writes. Bash completes words in a folder with
known files, by the script of a program with a known help text.

    completions.py
"""

import os
import pty
import select
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SCRIPT = ROOT / "scripts/packaging/completions.py"

# In the layout of CLI11 2.1. The second line of --mesh begins with the name of an option. A single blank separates
# --level-for-the-whole-scene from its description.
HELP = """Shows a surface.
Usage: sample [OPTIONS] [files...]

Positionals:
  files FILE ...              a cage and a height map

Options:
  -h,--help                   Print this help message and exit
  --mesh FILE                 instead of a scene: an OBJ file, as sculpting programs and
                              --export of other programs write it
  --up AXIS:{auto,x,-x}       axis of the cage that points upwards
  --level L|auto=auto         tessellation level
  --maps DIR                  folder for height maps
  --count N                   number of copies
  --representation LIST=cvert Excludes: --compare
                              list of representations
  --compare Excludes: --representation
                              all representations
  --level-for-the-whole-scene a flag
  -o,--output FILE=picture.png
                              picture to write
  --version                   print the version, and exit
"""
OPTIONS = (
    "--help --mesh --up --level --maps --count --representation --compare --level-for-the-whole-scene "
    "--output --version"
).split()

# The layout of later versions of CLI11.
LATER_HELP = """Shows a surface.


sample [OPTIONS] raster


POSITIONALS:
  raster FILE REQUIRED        elevation raster

OPTIONS:
  -h,     --help              Print this help message and exit
  -o,     --output FILE       picture to write
          --maps DIR          folder for height maps
          --version           print the version, and exit
"""

# Calls the function that completes `sample` as bash does, with the given words, and completes the last word. Prints the
# results, and the calls of compopt, which works only while readline completes.
DRIVER = """
compopt() { echo "compopt $*"; }
. "$1"
shift
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
set -- $(complete -p sample)
while [ "$1" != -F ]; do shift; done
"$2"
printf '%s\\n' "${COMPREPLY[@]}"
"""


def written(folder, help_text, name="sample"):
    """Writes the script of a program that prints the help text, and returns its path."""
    program = Path(folder) / "program.sh"
    program.write_text("#!/bin/sh\n[ \"$1\" = --help ] || exit 1\ncat << 'END'\n" + help_text + "END\n")
    completion = Path(folder) / "completions" / name
    subprocess.run([sys.executable, "-B", SCRIPT, completion, "sh", program], check=True)
    return completion


class Sample(unittest.TestCase):
    help_text = HELP

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.script = written(self.folder.name, self.help_text)

    def completed(self, *words):
        """Returns the words that the function returns, and the arguments of compopt."""
        done = subprocess.run(
            ["bash", "--norc", "-c", DRIVER, "bash", self.script, "sample", *words],
            capture_output=True,
            text=True,
            check=True,
        )
        self.assertEqual(done.stderr, "")
        lines = done.stdout.split("\n")
        switches = [line.split(" ", 1)[1] for line in lines if line.startswith("compopt ")]
        return [line for line in lines if line and not line.startswith("compopt ")], switches


class KnownHelp(Sample):
    def test_bash_accepts_the_script(self):
        done = subprocess.run(["bash", "-n", self.script], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_options_are_completed_once(self):
        self.assertEqual(sorted(self.completed("--")[0]), sorted(OPTIONS))
        self.assertEqual(self.completed("--ver")[0], ["--version"])
        self.assertEqual(self.completed("a.obj", "b.png", "-o", "c.png", "--me")[0], ["--mesh"])
        self.assertEqual(self.completed("--export")[0], [])

    def test_options_without_a_value_are_followed_by_options(self):
        for flag in ("--compare", "--level-for-the-whole-scene", "--help"):
            self.assertEqual(self.completed(flag, "--ver")[0], ["--version"], flag)

    def test_files_follow_paths_and_nothing_else(self):
        """The option `default` of complete, which completes files, stays on only where files may follow."""
        self.assertIn("complete -o default ", self.script.read_text())
        for words in (
            ["--mesh", ""],
            ["-o", ""],
            ["--output", "p"],
            ["--output", "="],
            ["--output", "=", "p"],
            [""],
            ["a.obj", ""],
        ):
            self.assertEqual(self.completed(*words), ([], []), words)
        for words in (["--count", ""], ["--representation", ""], ["--representation", "=", "c"]):
            self.assertEqual(self.completed(*words), ([], ["+o default"]), words)
        self.assertEqual(self.completed("--maps", ""), ([], ["+o default -o dirnames"]))
        self.assertEqual(self.completed("--ver")[1], ["+o default"])

    def test_listed_words_are_completed(self):
        self.assertEqual(self.completed("--up", "")[0], ["auto", "x", "-x"])
        self.assertEqual(self.completed("--up", "-")[0], ["-x"])
        self.assertEqual(self.completed("--up", "=", "a")[0], ["auto"])
        self.assertEqual(self.completed("--level", "")[0], ["auto"])

    def test_readline_completes_options_and_files(self):
        """Types into an interactive bash, as the driver above cannot show what readline does with the results."""
        folder = Path(self.folder.name) / "files"
        (folder / "maps of skin").mkdir(parents=True)
        (folder / "map.obj").write_text("")
        (folder / "cage.obj").write_text("")
        typed = {
            "sample --ver\t": ["--version"],
            "sample --mesh ca\t": ["--mesh", "cage.obj"],
            "sample --mesh=ca\t": ["--mesh=cage.obj"],
            "sample ca\t": ["cage.obj"],
            "sample --maps ma\t": ["--maps", "maps of skin/"],
            "sample --count ca\t": ["--count", "ca"],
            "sample --up au\t": ["--up", "auto"],
        }
        for line, expected in typed.items():
            self.assertEqual(self.typed(folder, line), expected, line)

    def typed(self, folder, line):
        """Returns the arguments of the command that bash runs after a line is typed and ended."""
        child, terminal = pty.fork()
        if child == 0:
            os.chdir(folder)
            environment = {"PATH": os.environ["PATH"], "TERM": "dumb", "HOME": str(folder), "PS1": "", "HISTFILE": ""}
            os.execvpe("bash", ["bash", "--norc", "--noprofile", "-i"], environment)
        self.addCleanup(os.waitpid, child, 0)
        self.addCleanup(os.close, terminal)
        out = folder.parent / "out"
        out.unlink(missing_ok=True)
        os.write(
            terminal,
            f"bind 'set bell-style none'; . {self.script}; "
            f"sample() {{ printf '%s\\n' \"$@\" > {out}.new; mv {out}.new {out}; }}\n".encode(),
        )
        os.write(terminal, (line + "\nexit\n").encode())
        end = time.monotonic() + 60
        while time.monotonic() < end:
            if select.select([terminal], [], [], 1)[0]:
                try:
                    if not os.read(terminal, 4096):
                        break
                except OSError:  # the end on Linux
                    break
        return out.read_text().splitlines()


class LaterLayout(Sample):
    help_text = LATER_HELP

    def test_options_and_files_are_completed(self):
        self.assertEqual(sorted(self.completed("--")[0]), ["--help", "--maps", "--output", "--version"])
        for words in ([""], ["-o", ""], ["--output", ""]):
            self.assertEqual(self.completed(*words), ([], []), words)
        self.assertEqual(self.completed("--maps", "")[1], ["+o default -o dirnames"])


class Failures(unittest.TestCase):
    def test_help_without_options_and_programs_that_fail_are_errors(self):
        with tempfile.TemporaryDirectory() as folder:
            for command, message in ((["echo"], "sample --help .*options"), (["false"], "false .* 1, .* 0")):
                completion = Path(folder) / "sample"
                done = subprocess.run(
                    [sys.executable, "-B", SCRIPT, completion, *command], capture_output=True, text=True
                )
                self.assertEqual(done.returncode, 1)
                self.assertRegex(done.stderr, message)
                self.assertFalse(completion.exists())


if __name__ == "__main__":
    unittest.main()
