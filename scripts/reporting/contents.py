# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The sections of the report. templates/sections.txt has their texts, in this order."""

from dataclasses import dataclass
from pathlib import Path

from . import checks, errors, gpu, levels, measurements, memory, noise, paper, relations, scale, tradeoffs

HARD_CASES = Path(__file__).resolve().parents[2] / "build/release/tests/hard_cases"
TEXTS = Path(__file__).parent / "templates/sections.txt"


@dataclass
class Section:
    """missing: the measurement that an empty section asks for. parts: contents. commands: the commands that measured
    them."""

    name: str
    group: str
    title: str
    missing: str
    text: str = ""
    parts: tuple = ()
    commands: tuple = ()


def texts(main):
    """Returns all sections without parts. main: the scene that stands for the paper's T-rex."""
    found = []
    for line in TEXTS.read_text(encoding="utf-8").replace("{main}", main).splitlines():
        if line.startswith(" "):
            found[-1].text += line.strip() + " "
        else:
            found.append(Section(*line.split(" | ")))
    return found


def sections(data, against=None, source="", scale_folder=""):
    """Returns all Sections; for a user's cages only those with contents. source: name of the folder of records."""
    found = {
        "tradeoffs": tradeoffs.section(data), "levels": levels.section(data), "isas": levels.isas(data),
        "gpu": gpu.section(data), "errors": errors.section(data), "relations": relations.section(data),
        "figure10": paper.figure_10(data), "figure11": paper.figure_11(data), "pictures": paper.portraits(data),
        "figure16": paper.figure_16(data), "figure17": memory.section(data), "bins": errors.bins(data),
        "growth": levels.growth(data), "scale": scale.section(scale_folder), "entrances": measurements.entrances(data),
        "robustness": checks.section(data), "hard": checks.hard_cases(HARD_CASES), "all": measurements.section(data),
        "run": noise.section(data, against, source),
    }  # fmt: skip
    shown = texts(data.paper_scene())
    for section in shown:
        section.parts, commands = found[section.name]
        section.commands = list(dict.fromkeys(commands))
    return [section for section in shown if section.parts or not data.is_own()]
