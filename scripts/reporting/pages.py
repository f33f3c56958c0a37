# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Renders the HTML page and the Markdown tables with the templates next to this file."""

import re
from pathlib import Path

import jinja2
from markupsafe import Markup, escape

from .formats import Fold, Table, Title

VERDICTS = {"holds": "yes", "does not hold": "no", "fails": "no", "not measured": "none", "not run": "none"}


def raised(text):
    """Text with frame levels as superscripts: cLEAF^2."""
    return Markup(re.sub(r"\^(\w+)", r"<sup>\1</sup>", str(escape(text))))


def verdict_of(cell):
    """Style class of a cell with a verdict."""
    return next((style for words, style in VERDICTS.items() if str(cell).startswith(words)), "")


def kind_of(part):
    """Name of the kind of a part, by which a template chooses how to show it."""
    if type(part) is str:
        return "missing" if part.startswith("No data") else "text"
    return {Title: "title", Table: "table", Fold: "fold", list: "pictures", dict: "facts"}[type(part)]


def render(template, **names):
    templates = jinja2.FileSystemLoader(Path(__file__).parent / "templates")
    layout = {"autoescape": template.endswith("html"), "trim_blocks": True, "lstrip_blocks": True}
    environment = jinja2.Environment(loader=templates, **layout)
    environment.filters |= {"raised": raised, "verdict": verdict_of, "kind": kind_of}
    return environment.get_template(template).render(**names)
