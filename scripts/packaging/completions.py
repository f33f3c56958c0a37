#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes a completion script of bash for a program, from the output of the program with --help.

    completions.py FILE PROGRAM [ARGUMENT...]

FILE gets the script; its name is the name of the completed command. The command PROGRAM ARGUMENT... --help must print
the help text in the layout of CLI11. The type of a value decides its completion:

    FILE                     files
    DIR                      folders
    TYPE:{a,b}, a|b, L|auto  the words that are listed, without types, which contain capitals
    other types              nothing

Other words are completed to options. If the program has positional arguments of type FILE, words that do not begin with
a dash are completed to files instead.
"""

import argparse
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

# "  -o,--output FILE=a.tif   text". Later versions of CLI11 align long names: "  -h,     --help", "          --cell".
OPTION = re.compile(r"^ {1,12}(?:(?P<short>-\w),\s*)?(?P<long>--[\w-]+)(?: (?P<value>\S+))?")
POSITIONAL = re.compile(r"^ {1,8}(?P<name>\w[\w-]*) (?P<value>\S+)")
HEADING = re.compile(r"^(?P<title>[A-Z][A-Za-z ]*):\s*$")
COLUMN = 30  # where CLI11 puts the descriptions
RELATIONS = ("Excludes:", "Needs:", "REQUIRED")  # follow the name of an option without a value


@dataclass(frozen=True)
class Option:
    names: tuple  # for example ("-o", "--output")
    value: str  # as in the help text, for example "NAME=cvert"; empty if the option has no value


def value_of(match):
    """Returns the type of the value, or "" if the word after the name is not a type."""
    value = match["value"] or ""
    return "" if value in RELATIONS or match.start("value") == COLUMN else value


def parse(help_text):
    """Returns the options of a help text, and the types of its positional arguments."""
    options, positionals, section = [], [], ""
    for line in help_text.splitlines():
        heading = HEADING.match(line)
        option, positional = OPTION.match(line), POSITIONAL.match(line)
        if heading:
            section = heading["title"].lower()
        elif option and section.startswith("options"):
            names = tuple(name for name in (option["short"], option["long"]) if name)
            options.append(Option(names, value_of(option)))
        elif positional and section.startswith("positionals"):
            positionals.append(value_of(positional))
    return options, positionals


def type_of(value):
    """Returns the type of a value without its restriction and its default: FILE for "FILE=a.tif"."""
    return re.split(r"[:=]", value)[0]


def words_of(value):
    """Returns the words that a value may have, as far as its type lists them."""
    listed = re.search(r"\{([^}]*)\}", value)
    if listed:
        return listed[1].split(",")
    alternatives = value.split("=")[0].split("|")
    return [word for word in alternatives if len(alternatives) > 1 and re.fullmatch(r"[a-z][a-z0-9-]*", word)]


def branch(names, *lines):
    return ["    %s)" % "|".join(names), *("      " + line for line in lines), "      ;;"]


def script_of(program, help_text):
    """Returns the completion script. Throws ValueError if the help text has no options."""
    options, positionals = parse(help_text)
    if not options:
        raise ValueError("%s --help lists no options: expected the layout of CLI11" % program)
    function = "_" + re.sub(r"\W", "_", program)
    files, folders, others, branches = [], [], [], []
    for option in options:
        words = words_of(option.value)
        if words:
            branches += branch(option.names, 'words="%s"' % " ".join(words))
        elif type_of(option.value) == "FILE":
            files += option.names
        elif type_of(option.value) == "DIR":
            folders += option.names
        elif option.value:
            others += option.names
    if files:
        branches += branch(files, "return")
    if folders:
        branches += branch(folders, "compopt +o default -o dirnames", "return")
    if others:
        branches += branch(others, "compopt +o default", "return")
    takes_files = any(type_of(value) == "FILE" for value in positionals)
    names = " ".join(name for option in options for name in option.names)
    branches += branch("*", *(["[[ $word == -* ]] || return"] if takes_files else []), 'words="%s"' % names)
    return "\n".join(
        [
            "# Completion of %s in bash, from its --help by scripts/packaging/completions.py." % program,
            "",
            "%s()" % function,
            "{",
            "  local word=${COMP_WORDS[COMP_CWORD]} option=${COMP_WORDS[COMP_CWORD-1]} words",
            "  COMPREPLY=()",
            "  if [[ $word == = ]]; then # bash makes a word of the = in --option=value",
            "    word=",
            "  elif [[ $option == = ]]; then",
            "    option=${COMP_WORDS[COMP_CWORD-2]}",
            "  fi",
            "  # Without a result, bash completes files: see the last line.",
            "  case $option in",
            *branches,
            "  esac",
            "  compopt +o default",
            '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")',
            "}",
            "complete -o default -F %s %s" % (function, program),
            "",
        ]
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="completion script to write")
    parser.add_argument("command", nargs=argparse.REMAINDER, help="program and arguments, to which --help is added")
    arguments = parser.parse_args()
    if not arguments.command:
        parser.error("PROGRAM is missing")
    done = subprocess.run(arguments.command + ["--help"], stdout=subprocess.PIPE, universal_newlines=True, check=False)
    if done.returncode:
        raise ValueError("%s --help exits with %d, expected 0" % (" ".join(arguments.command), done.returncode))
    arguments.file.parent.mkdir(parents=True, exist_ok=True)
    arguments.file.write_text(script_of(arguments.file.name, done.stdout), encoding="utf-8")


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError) as error:
        sys.exit("completions.py: %s" % error)
