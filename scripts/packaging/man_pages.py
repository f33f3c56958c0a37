#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Manual pages of the functions that our public headers add, laid out as Embree's own.

A page is the comment above a function, and the types among its arguments that the same header
declares. Functions that follow one another under one comment share a page: the others lead to that
of the first. A function without a comment is an error.
"""

import argparse
import os
import re
import sys

DECLARATION = re.compile(r"^(?:RTC_API|RTC_FORCEINLINE|CBVH_API)\s+(?P<returns>[\w\s*]+?)\s*(?P<name>(?:rtc|cbvh)\w+)\s*\((?P<arguments>[^)]*)\)")
TYPE = re.compile(r"^(?:struct|enum) (?:CBVH_ALIGNED )?(\w+)\n\{.*?^\};", re.S | re.M)
ITEM = re.compile(r"^(?:- |[a-z]\w*(?:, [a-z]\w*)*: )")

# By the folder of a header: the section of its pages, and what they say of failures.
SECTIONS = {"embree3": "3embree3", "cbvh": "3cbvh"}
FAILURES = {
    "embree3": "On failure an error code is set that can be queried using rtcGetDeviceError.",
    "cbvh": "What returns enum CbvhError returns CBVH_OK, or on failure a code of which cbvhGetErrorText says more.",
}


def comment_text(lines):
    """The lines of a /* comment */ without what makes them one."""
    text = re.sub(r"^/\*|\*/$", "", "\n".join(lines).strip())
    return [re.sub(r"^ ?\*? ?", "", line).rstrip() for line in text.strip().split("\n")]


def paragraphs(lines):
    """Joined lines: a paragraph ends at an empty line, before an argument and before a list's entry."""
    result = []
    begin = True
    for line in lines:
        text = line.strip()
        if not text:
            begin = True
        elif begin or ITEM.match(text):
            result.append(text)
            begin = False
        else:
            result[-1] += " " + text
    return result


def functions_of(header):
    """[(comment, [(name, declaration)])]: what each comment is of."""
    result = []
    comment, functions = None, []
    lines = header.split("\n")
    i = 0
    while i < len(lines):
        line = lines[i]
        if line.startswith("/*"):
            begin = i
            while "*/" not in lines[i]:
                i += 1
            comment, functions = comment_text(lines[begin:i + 1]), []
        elif DECLARATION.match(line):
            found = DECLARATION.match(line)
            if comment is None:
                raise ValueError(found["name"] + " has no comment")
            if not functions:
                result.append((comment, functions))
            functions.append((found["name"], declaration(found)))
        elif not line.strip():
            # Functions after an empty line are not the comment's; a body that follows is skipped.
            comment = None
        i += 1
    return result


def declaration(found):
    arguments = [" ".join(argument.split()) for argument in found["arguments"].split(",")]
    return "%s %s(\n  %s\n);" % (" ".join(found["returns"].split()), found["name"], ",\n  ".join(arguments))


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def code(text):
    return [".IP", ".nf", "\\f[C]"] + [escaped(line) for line in text.split("\n")] + ["\\f[R]", ".fi"]


def page(name, version, folder, include, comment, declarations, types, others):
    texts = paragraphs(comment)
    errors = [text for text in texts if text.startswith("Errors: ")]
    described = [text for text in texts if text not in errors]
    summary = re.split(r"[.:;] |\.$|, which ", described[0])[0]
    out = ['.TH "%s" "3" "" "Embree CBVH %s" "Embree Ray Tracing Kernels 3"' % (name, version), ".hy"]
    out += [".SS NAME"] + code("%s - %s" % (name, summary[0].lower() + summary[1:]))
    out += [".SS SYNOPSIS"] + code("\n\n".join(["#include <%s/%s>" % (folder, include)] + types + declarations))
    out += [".SS DESCRIPTION"]
    for text in described:
        if ITEM.match(text):
            mark, rest = re.match(r"(- |\w+(?:, \w+)*: )(.*)", text).groups()
            out += ['.IP "%s" 4' % ("\\(bu" if mark == "- " else mark.strip(": ")), escaped(rest)]
        else:
            out += [".PP", escaped(text)]
    out += [".SS EXIT STATUS", ".PP", FAILURES[folder]]
    for text in errors:
        out += [".PP", escaped(text[len("Errors: "):][0].upper() + text[len("Errors: ") + 1:])]
    out += [".SS SEE ALSO", ".PP", escaped(", ".join("[%s]" % other for other in others if other != name))]
    return "\n".join(out) + "\n"


def write(folder, name, section, text):
    with open(os.path.join(folder, name + "." + section), "w", encoding="utf-8") as file:
        file.write(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("version")
    parser.add_argument("folder")
    parser.add_argument("headers", nargs="+")
    arguments = parser.parse_args()
    version, folder = arguments.version, arguments.folder
    os.makedirs(folder, exist_ok=True)
    for path in arguments.headers:
        with open(path, encoding="utf-8") as file:
            header = file.read()
        include = os.path.basename(os.path.dirname(path))
        section = SECTIONS[include]
        types = {found[1]: found[0] for found in TYPE.finditer(header)}
        documented = functions_of(header)
        others = [functions[0][0] for _, functions in documented]
        for comment, functions in documented:
            declarations = [text for _, text in functions]
            used = [types[name] for name in types if re.search(r"\b%s\b" % name, "\n".join(declarations))]
            # an enumeration that only a structure names
            used = [types[name] for name in types if types[name] not in used and re.search(r"\b%s\b" % name, "\n".join(used))] + used
            first = functions[0][0]
            write(folder, first, section, page(first, version, include, os.path.basename(path), comment, declarations, used, others))
            for name, _ in functions[1:]:
                write(folder, name, section, ".so man3/%s.%s\n" % (first, section))


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError) as error:
        sys.exit("man_pages.py: %s" % error)
