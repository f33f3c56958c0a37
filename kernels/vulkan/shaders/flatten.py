#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""flatten.py SHADER OUTPUT

Writes the file that applications include: SHADER with all that it includes, as GLSL without C++. Global names get a
prefix, so that they do not collide with names of the application. The headers of kernels/cvert and kernels/cbvh remain
the only source.
"""

import os
import re
import sys

# Headers that define the language that C++ and GLSL share. Their first comment explains macros, which are replaced.
LANGUAGE_HEADERS = ("language.h", "bytes.h", "int3.h")
# Names of that language, and their equivalents in GLSL.
LANGUAGE = {
    "CBVH_BEGIN": "",
    "CBVH_END": "",
    "CVERT_BEGIN": "",
    "CVERT_END": "",
    "CVERT_FUNCTION": "",
    "CVERT_INLINE": "",
    "CVERT_REAL": "",
    "CVERT_WIDE": "",
    "CVERT_CONSTANT": "const",
    "CVERT_PRECISE": "precise",
    "Real": "float",
    "uint32_t": "uint",
    "Int3": "ivec3",
    "CBVH_ADDRESS": "uvec2",
}
# Macros with an argument, and their equivalents in GLSL.
MACROS = {
    "CVERT_OF": r"\1",
    "CVERT_OF_WIDE": r"\1",
    "CVERT_IN": r"\1",
    "CVERT_AS_FLOAT": r"\1",
    "CVERT_BOOL": "bool",
    "CVERT_POINTER": "uvec2",
}

HEAD = """// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

"""


def glsl_of(text):
    """Returns a header as it is if VULKAN is defined, with the conditions on VULKAN resolved."""
    out, stack = [], []  # stack: per open condition, whether its part is kept; None for other conditions
    for line in text.split("\n"):
        words = line.split()
        directive = words[0] if words else ""
        if directive in ("#ifdef", "#ifndef") and words[1] == "VULKAN":
            stack.append(directive == "#ifdef")
            continue
        if directive in ("#if", "#ifdef", "#ifndef"):
            stack.append(None)
        elif directive == "#else" and stack[-1] is not None:
            stack[-1] = not stack[-1]
            continue
        elif directive == "#endif" and stack.pop() is not None:
            continue
        if False not in stack:
            out.append(line)
    return "\n".join(out)


def gather(path, seen):
    """Returns a file with its includes in place. Each file is included once."""
    path = os.path.normpath(path)
    if path in seen:
        return ""
    seen.append(path)
    with open(path, encoding="utf-8") as file:
        text = glsl_of(file.read())
    if os.path.basename(path) in LANGUAGE_HEADERS:
        text = re.sub(r"^/\*.*?\*/\n", "", text, count=1, flags=re.S | re.M)

    def included(match):
        return gather(os.path.join(os.path.dirname(path), match.group(1)), seen)

    text = re.sub(r'^#include "([^"]+)"[^\n]*$', included, text, flags=re.M)
    guard = re.search(r"^#ifndef (\w+_(?:H|GLSL))\n#define \1\n", text, flags=re.M)
    if guard and path != seen[0]:
        end = text.rindex("#endif")
        text = text[: guard.start()] + text[guard.end() : end] + text[end + len("#endif") :]
    return text.replace(HEAD, "", 1) if path != seen[0] else text


def without_language(text):
    """Replaces the macros of the shared language by GLSL."""
    text = re.sub(r"^#define (?:%s)\b.*\n" % "|".join([*LANGUAGE, *MACROS]), "", text, flags=re.M)
    for name, value in MACROS.items():
        text = re.sub(r"\b%s\((\w+)\)" % name, value, text)
    for name, value in LANGUAGE.items():
        text = re.sub(r"\b%s\b ?(?=\w)" % name if not value else r"\b%s\b" % name, value, text)
        text = re.sub(r"^%s\n" % name, "", text, flags=re.M)
    return re.sub(r"\bCVERT_", "CBVH_", text)  # one prefix in the application's shader


def with_prefix(text):
    """Adds a prefix to global names that do not have one."""
    code = re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.S)
    names = set(re.findall(r"(?:^struct|\bbuffer) (\w+)", code, flags=re.M)) - {"Type"}
    names |= set(re.findall(r"^(?:const )?\w+(?:\[\w*\])? (\w+) *(?:\(|=|\[)", code, flags=re.M))
    names |= set(re.findall(r"^#define (\w+)", code, flags=re.M))
    # several in one declaration
    for declaration in re.findall(r"^const \w+ (\w+ =[^;]*);", code, flags=re.M):
        names |= set(re.findall(r"(?:^|, )(\w+) =", declaration))
    names = {name for name in names if not name.lower().startswith("cbvh")}
    pattern = re.compile(r"(?<![\w.])(?:%s)\b(?=(\()?)" % "|".join(sorted(names)))

    def renamed(match, is_comment):
        # in comments, a word in lowercase is a name only if it is called
        is_word = is_comment and match[0].islower() and not match[1]
        return match[0] if is_word else "cbvh_" + match[0]

    parts = re.split(r"(/\*.*?\*/|//[^\n]*)", text, flags=re.S)  # code and comments in turn
    return "".join(pattern.sub(lambda match: renamed(match, bool(i % 2)), part) for i, part in enumerate(parts))


def main():
    shader, output = sys.argv[1:]
    text = with_prefix(without_language(gather(shader, [])))
    text = re.sub(r"[ \t]+\n", "\n", text)
    text = re.sub(r"\n{3,}", "\n\n", text)
    with open(output, "w", encoding="utf-8") as file:
        file.write(text.rstrip() + "\n")


main()
