#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes manual pages for the functions of our public headers, in the layout of Embree's own pages.

    man_pages.py VERSION FOLDER HEADER...

A page consists of the comment above a function and of all types that its declaration refers to, with their comments.
Consecutive functions under one comment share a page; the pages of the other functions refer to it. A function without a
comment is an error. The result type of all functions of a header, such as an error code, has a page of its own.

The beginning of a paragraph decides its place on the page:

    name: ...            an argument, or several (u, v: ...), if the functions have arguments of these names
    Returns ...          RETURN VALUE. In the comment of several functions: Return ...
    Errors: ...          ERRORS
    Thread safety: ...   NOTES
    - ...                an entry of a list
"""

import argparse
import os
import re
import sys
from dataclasses import dataclass

FUNCTION = re.compile(
    r"^(?:RTC_API|RTC_FORCEINLINE|CBVH_API)\s+(?P<returns>[\w\s*]+?)\s*(?P<name>(?:rtc|cbvh)\w+)\s*"
    r"\((?P<arguments>[^)]*)\)"
)
TYPE = re.compile(
    r"(?P<comment>^/\*(?:(?!\*/).)*\*/\n)?(?P<text>^(?:struct|enum) (?:CBVH_ALIGNED )?(?P<name>\w+)\s*\{.*?^\};"
    r"|^typedef [^;{]*?\(\*\s*(?P<callback>\w+)\)\([^;]*\);)",
    re.S | re.M,
)
LABEL = re.compile(r"^(?P<names>[A-Za-z]\w*(?:, [A-Za-z]\w*)*):\s+(?P<text>.*)", re.S)
DEFAULT = re.compile(  # the default of a member in C++
    r" (?:(?:RTC_COMPRESSION|CBVH)_SIZE_OF\(\w+\)|RTC_DEFAULT\([^)]*\)|RTC_ZERO|CBVH_ZERO(?:14)?)(?=[;,])"
)
INIT_FUNCTION = re.compile(r"Call \w+Init\w+ first")  # in the comment of a struct; sets structSize
STRUCT_SIZE = "Set structSize to the sizeof of its struct: in C++, T s; does so; in C, T s = {.structSize = sizeof(s)}."
SECTIONS = {"Returns ": "RETURN VALUE", "Return ": "RETURN VALUE", "Errors: ": "ERRORS", "Thread safety: ": "NOTES"}
FIRST_VERSION = "0.9.0"
SECOND_VERSION = "1.0.0"
FUNCTIONS_OF_FIRST_VERSION = frozenset(
    """
    rtcGetDeviceCompressionProperty rtcGetSceneCompressionStatistics rtcGetVulkanDeviceHandles
    rtcGetVulkanDeviceInfo rtcGetVulkanDevices rtcGetVulkanRayOrderBytes rtcGetVulkanSceneAddress
    rtcGetVulkanSceneStatistics rtcInitCompressionArguments rtcIsVulkanTraceDone
    rtcNewVulkanDevice rtcNewVulkanDeviceFromHandles rtcNewVulkanScene rtcRecordVulkanIntersect
    rtcRecordVulkanIntersectInOrder rtcRecordVulkanOccluded rtcRecordVulkanOccludedInOrder
    rtcRecordVulkanRayOrder rtcReleaseVulkanDevice rtcReleaseVulkanScene rtcRetainVulkanDevice
    rtcRetainVulkanScene rtcSetGeometryCompression rtcStartVulkanIntersect
    rtcStartVulkanOccluded
    """.split()
)


@dataclass(frozen=True)
class Library:
    """Settings that the pages of all headers in one folder share."""

    section: str
    failures: str = ""  # begins the section ERRORS of every page, as in Embree's own pages
    own_pages: tuple = ()  # types that have a page of their own


LIBRARIES = {
    "embree3": Library("3embree3", "On failure an error code is set that can be queried using rtcGetDeviceError."),
    "cbvh": Library("3cbvh", own_pages=("CbvhError",)),
}


@dataclass(frozen=True)
class Type:
    """A struct, an enumeration or a callback: its declaration and the comment above it."""

    name: str
    comment: str
    text: str


@dataclass(frozen=True)
class Group:
    """Consecutive functions under one comment."""

    comment: list  # lines
    names: list
    declarations: list
    arguments: set  # names of the arguments of all functions


def comment_lines(text):
    """Returns the lines of a /* comment */ without its delimiters."""
    text = re.sub(r"^/\*|\*/$", "", text.strip())
    return [re.sub(r"^ ?\*? ?", "", line).rstrip() for line in text.strip().split("\n")]


def paragraphs(lines, arguments):
    """Joins lines to paragraphs. A paragraph ends at an empty line, and before an argument, a section or an entry of a
    list."""
    result, begins = [], True
    for line in map(str.strip, "\n".join(lines).replace(" Thread safety: ", "\nThread safety: ").split("\n")):
        label = LABEL.match(line)
        is_argument = label and set(label["names"].split(", ")) <= arguments
        if not line:
            begins = True
        elif begins or is_argument or line.startswith(("- ", "Errors: ", "Thread safety: ")):
            result.append(line)
            begins = False
        else:
            result[-1] += " " + line
    return result


def types_of(header):
    """Returns all types of a header by name."""
    header = DEFAULT.sub("", header)
    found = (Type(m["name"] or m["callback"], m["comment"] or "", m["text"]) for m in TYPE.finditer(header))
    return {type_.name: type_ for type_ in found}


def groups_of(header):
    """Returns all documented functions of a header."""
    result, comment, group = [], None, None
    lines = header.split("\n")
    i = 0
    while i < len(lines):
        function = FUNCTION.match("\n".join(lines[i:]))  # a declaration may have several lines
        if lines[i].startswith("/*"):
            begin = i
            while "*/" not in lines[i]:
                i += 1
            comment, group = comment_lines("\n".join(lines[begin : i + 1])), None
        elif function:
            if comment is None:
                raise ValueError(function["name"] + " has no comment")
            if group is None:
                group = Group(comment, [], [], set())
                result.append(group)
            arguments = [" ".join(argument.split()) for argument in function["arguments"].split(",")]
            group.names.append(function["name"])
            returns = " ".join(function["returns"].split())
            group.declarations.append("%s %s(\n  %s\n);" % (returns, function["name"], ",\n  ".join(arguments)))
            group.arguments.update(
                re.sub(r"\[\d*\]$", "", argument).split(" ")[-1].strip("*") for argument in arguments
            )
        elif not lines[i].strip():
            comment = None  # functions after an empty line have a comment of their own
        i += 1
    return result


def types_used(texts, types, without):
    """Returns the types that declarations refer to, each after the types that it depends on."""
    result = []

    def visit(text):
        for name, type_ in types.items():
            if name not in without and type_ not in result and re.search(r"\b%s\b" % name, text) and type_.text != text:
                visit(type_.text)
                if type_ not in result:
                    result.append(type_)

    for text in texts:
        visit(text)
    return result


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def code(text):
    return [".IP", ".nf", "\\f[C]"] + [escaped(line) for line in text.split("\n")] + ["\\f[R]", ".fi"]


def prose(texts, arguments):
    out = []
    for text in texts:
        label = LABEL.match(text)
        if text.startswith("- "):
            out += ['.IP "\\(bu" 4', escaped(text[2:])]
        elif label and set(label["names"].split(", ")) <= arguments:
            out += ['.IP "%s" 4' % label["names"], escaped(label["text"])]
        else:
            out += [".PP", escaped(text)]
    return out


def head(names, section, version, summary, include, synopsis):
    """Programs that index pages read the section NAME, which must be plain text and list all names of the page."""
    out = ['.TH "%s" "%s" "" "Embree CBVH %s" "Embree Ray Tracing Kernels 3"' % (names[0], section, version), ".hy"]
    out += [".SH NAME", escaped("%s - %s" % (", ".join(names), summary[0].lower() + summary[1:]))]
    return out + [".SH SYNOPSIS"] + code("\n\n".join(["#include <%s>" % include] + synopsis))


def summary_of(text):
    return re.split(r"[.:;] |\.$|, which ", text)[0]


def see_also(names, section):
    return [".SH SEE ALSO", ".PP", escaped(", ".join("%s(%s)" % (name, section) for name in names))]


def page_of(group, version, include, library, types, others):
    texts = paragraphs(group.comment, group.arguments)
    parts = {section: [] for section in ("DESCRIPTION", *SECTIONS.values())}
    for text in texts:
        begin = next((begin for begin in SECTIONS if text.startswith(begin)), None)
        # The first paragraph is always the description, even if it begins with "Returns".
        section = SECTIONS[begin] if begin and text != texts[0] else "DESCRIPTION"
        if section in ("ERRORS", "NOTES"):
            text = text.split(": ", 1)[1] if section == "ERRORS" else text
            text = text[0].upper() + text[1:]
        parts[section].append(text)
    if library.failures:
        parts["ERRORS"].insert(0, library.failures)
    used = types_used(group.declarations, types, library.own_pages)
    synopsis = [type_.comment + type_.text for type_ in used] + group.declarations
    if any(" structSize;" in type_.text and not INIT_FUNCTION.search(type_.comment) for type_ in used):
        parts["NOTES"].append(STRUCT_SIZE)
    out = head(group.names, library.section, version, summary_of(texts[0]), include, synopsis)
    for section, found in parts.items():
        if found:
            out += [".SH " + section] + prose(found, group.arguments)
    since = FIRST_VERSION if group.names[0] in FUNCTIONS_OF_FIRST_VERSION else SECOND_VERSION
    out += [".SH HISTORY", ".PP", "Available since %s." % since]
    named = [name for name in library.own_pages if re.search(r"\b%s\b" % name, "\n".join(group.declarations))]
    return (
        "\n".join(out + see_also(named + [name for name in others if name != group.names[0]], library.section)) + "\n"
    )


def page_of_type(type_, version, include, library, others):
    texts = paragraphs(comment_lines(type_.comment), set()) if type_.comment else [type_.name]
    out = head([type_.name], library.section, version, summary_of(texts[0]), include, [type_.text])
    return "\n".join(out + [".SH DESCRIPTION"] + prose(texts, set()) + see_also(others, library.section)) + "\n"


def write(folder, name, section, text):
    with open(os.path.join(folder, name + "." + section), "w", encoding="utf-8") as file:
        file.write(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("version", help="version of Embree CBVH, printed on each page")
    parser.add_argument("folder", help="folder of the pages; created if necessary")
    parser.add_argument("headers", nargs="+", help="headers to document")
    arguments = parser.parse_args()
    version, folder = arguments.version, arguments.folder
    os.makedirs(folder, exist_ok=True)
    for path in arguments.headers:
        with open(path, encoding="utf-8") as file:
            header = file.read()
        name = os.path.basename(os.path.dirname(path))
        library, include = LIBRARIES[name], "%s/%s" % (name, os.path.basename(path))
        types, groups = types_of(header), groups_of(header)
        others = [group.names[0] for group in groups]
        for group in groups:
            first = group.names[0]
            write(folder, first, library.section, page_of(group, version, include, library, types, others))
            for other in group.names[1:]:
                write(folder, other, library.section, ".so man3/%s.%s\n" % (first, library.section))
        for own in library.own_pages:
            if own in types:
                write(folder, own, library.section, page_of_type(types[own], version, include, library, others))


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError) as error:
        sys.exit("man_pages.py: %s" % error)
