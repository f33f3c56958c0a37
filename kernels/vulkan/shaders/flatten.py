#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""flatten.py SHADER OUTPUT

Writes the single file that applications include: SHADER with all its includes, as pure GLSL. Macros for C++ are
resolved, and global names get a prefix, so that they do not collide with the application's names.
"""

import os
import re
import sys

# Replacements in GLSL for the macros of cvert/basics/language.h, bytes.h and int3.h: without and with a parameter.
LANGUAGE = {"CBVH_BEGIN": "", "CBVH_END": "", "CVERT_BEGIN": "", "CVERT_END": "", "CVERT_FUNCTION": "",
            "CVERT_INLINE": "", "CVERT_REAL": "", "CVERT_WIDE": "", "CVERT_CONSTANT": "const",
            "CVERT_PRECISE": "precise", "Real": "float", "uint32_t": "uint", "Int3": "ivec3", "CBVH_ADDRESS": "uvec2"}
MACROS = {"CVERT_OF": r"\1", "CVERT_OF_WIDE": r"\1", "CVERT_IN": r"\1", "CVERT_AS_FLOAT": r"\1", "CVERT_BOOL": "bool",
          "CVERT_POINTER": "uvec2"}

HEAD = """// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

"""


def glsl_of(text):
    """Resolves conditions on VULKAN, which is defined."""
    out, stack = [], []  # stack: per open condition whether its lines are kept; None if it is not about VULKAN
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
    """Returns the text of a file with each included file inserted once, without guards."""
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


COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)
# Headers with macros for C++: comments at their beginning describe these.
DESCRIPTIONS = ("Macros with which the headers", "Access to memory in code shared", "Macros of cvert/basics/language.h")


def without_language(text):
    """Replaces the macros that let headers compile as C++, and removes their descriptions."""
    text = re.sub(r"^#define (?:%s)\b.*\n" % "|".join([*LANGUAGE, *MACROS]), "", text, flags=re.M)
    for begin in DESCRIPTIONS:
        text, count = re.subn(r"/\* %s.*?\*/\n" % begin, "", text, flags=re.S)
        if count != 1:
            raise SystemExit(f'flatten.py: found {count} comments that begin with "{begin}": expected 1')
    for name, value in MACROS.items():
        text = re.sub(r"\b%s\((\w+)\)" % name, value, text)
    for name, value in LANGUAGE.items():
        text = re.sub(r"\b%s\b ?(?=\w)" % name if not value else r"\b%s\b" % name, value, text)
        text = re.sub(r"^%s\n" % name, "", text, flags=re.M)
    return re.sub(r"\bCVERT_", "CBVH_", text)  # one prefix in the application's shader


def with_prefix(text):
    """Adds the prefix cbvh_ to global names that do not begin with cbvh. Comments keep the names."""
    code = COMMENT.sub("", text)
    names = set(re.findall(r"(?:^struct|\bbuffer) (\w+)", code, flags=re.M)) - {"Type"}
    names |= set(re.findall(r"^(?:const )?\w+(?:\[\w*\])? (\w+) ?(?:\(|=|\[)", code, flags=re.M))
    for declaration in re.findall(r"^const \w+ (\w+ =[^;]*);", code, flags=re.M):
        names |= set(re.findall(r"(?:^|, )(\w+) =", declaration))
    names = {name for name in names if not name.lower().startswith("cbvh")}
    known = re.compile(r"/\*.*?\*/|//[^\n]*|(?<![\w.])(?:%s)\b" % "|".join(sorted(names)), re.S)
    return known.sub(lambda match: match[0] if match[0][0] == "/" else "cbvh_" + match[0], text)


def main():
    shader, output = sys.argv[1:]
    text = with_prefix(without_language(gather(shader, [])))
    text = re.sub(r"[ \t]+\n", "\n", text)
    text = re.sub(r"\n{3,}", "\n\n", text)
    with open(output, "w", encoding="utf-8") as file:
        file.write(text.rstrip() + "\n")


main()
