#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""flatten.py SHADER OUTPUT

Makes the one file that applications include out of SHADER and all that it includes: as GLSL alone,
without what is C++, and with a prefix before every name, so that it gets along with an
application's own. The headers of kernels/cvert and kernels/cbvh stay the source; nothing is written twice.
"""

import os
import re
import sys

# Names of the language that headers share with C++ (cvert/basics/language.h, bytes.h, int3.h), and what they are in GLSL.
LANGUAGE = {"CBVH_BEGIN": "", "CBVH_END": "", "CVERT_BEGIN": "", "CVERT_END": "", "CVERT_FUNCTION": "", "CVERT_INLINE": "", "CVERT_REAL": "", "CVERT_WIDE": "",
            "CVERT_CONSTANT": "const", "CVERT_PRECISE": "precise", "Real": "float", "uint32_t": "uint", "Int3": "ivec3", "CBVH_ADDRESS": "uvec2"}
# Macros of types (also cvert/basics/bytes.h), and what they are.
MACROS = {"CVERT_OF": r"\1", "CVERT_OF_WIDE": r"\1", "CVERT_IN": r"\1", "CVERT_AS_FLOAT": r"\1", "CVERT_BOOL": "bool", "CVERT_POINTER": "uvec2"}

HEAD = """// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

"""


def glsl_of(text):
    """What is left of a header where VULKAN is defined: conditions on it are resolved."""
    out, stack = [], []  # of the open conditions: None, or whether the part is kept
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
    """The text of a file with its includes in place, each once."""
    path = os.path.normpath(path)
    if path in seen:
        return ""
    seen.append(path)
    with open(path, encoding="utf-8") as file:
        text = glsl_of(file.read())

    def included(match):
        return gather(os.path.join(os.path.dirname(path), match.group(1)), seen)

    text = re.sub(r'^#include "([^"]+)"[^\n]*$', included, text, flags=re.M)
    guard = re.search(r"^#ifndef (\w+_(?:H|GLSL))\n#define \1\n", text, flags=re.M)
    if guard and len(seen) and path != seen[0]:
        end = text.rindex("#endif")
        text = text[:guard.start()] + text[guard.end():end] + text[end + len("#endif"):]
    return text.replace(HEAD, "", 1) if path != seen[0] else text


def without_language(text):
    """Without the macros that make a header two languages."""
    text = re.sub(r"^#define (?:%s)\b.*\n" % "|".join([*LANGUAGE, *MACROS]), "", text, flags=re.M)
    for begin in ("What lets the headers of this folder", "Memory as shared code reads it"):
        text = re.sub(r"/\* %s.*?\*/\n" % begin, "", text, flags=re.S)
    for name, value in MACROS.items():
        text = re.sub(r"\b%s\((\w+)\)" % name, value, text)
    for name, value in LANGUAGE.items():
        text = re.sub(r"\b%s\b ?(?=\w)" % name if not value else r"\b%s\b" % name, value, text)
        text = re.sub(r"^%s\n" % name, "", text, flags=re.M)
    return re.sub(r"\bCVERT_", "CBVH_", text)  # one prefix in the application's shader


def with_prefix(text):
    """Global names that have no prefix of their own get one."""
    names = set(re.findall(r"(?:^struct|\bbuffer) (\w+)", text, flags=re.M)) - {"Type"}
    names |= set(re.findall(r"^(?:const )?\w+(?:\[\w*\])? (\w+) ?(?:\(|=|\[)", text, flags=re.M))
    # several in one declaration
    for declaration in re.findall(r"^const \w+ (\w+ =[^;]*);", text, flags=re.M):
        names |= set(re.findall(r"(?:^|, )(\w+) =", declaration))
    names = {name for name in names if not name.lower().startswith("cbvh")}
    for name in sorted(names):
        text = re.sub(r"(?<![\w.])%s\b" % name, "cbvh_" + name, text)
    return text


def main():
    shader, output = sys.argv[1:]
    text = with_prefix(without_language(gather(shader, [])))
    text = re.sub(r"[ \t]+\n", "\n", text)
    text = re.sub(r"\n{3,}", "\n\n", text)
    with open(output, "w", encoding="utf-8") as file:
        file.write(text.rstrip() + "\n")


main()
