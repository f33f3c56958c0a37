# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Formats numbers as text, and pandas frames as tables of text."""

import math
from dataclasses import dataclass

EXACT = 1e-3  # pixels: smaller errors are rounding


def is_known(value):
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def pixels(value):
    """An error in pixels; 0 if it is less than a tenth of EXACT."""
    if value < EXACT / 10:
        return "0" if value == 0 else f"<{EXACT / 10:.4f}"
    return f"{value:.{4 if value < 1 else 3 if value < 10 else 1}f}"


def signed(value):
    """Four digits and a sign; no sign if the value rounds to zero."""
    text = f"{value:+.4f}"
    return text if float(text) else "0.0000"


def digits(value):
    """Three digits."""
    return f"{value:.{3 if value < 1 else 2 if value < 10 else 1 if value < 100 else 0}f}"


def ratio(value):
    """Two digits after the point; large ratios have three digits in total."""
    return f"{value:.2f}" if value < 10 else digits(value)


def percent(value):
    return f"{100 * value:.1f}%"


def mib(count):
    return f"{digits(count / 2**20)} MiB"


@dataclass
class Table:
    """A table of text. words: number of columns of words, from the left."""

    heads: list
    rows: list
    words: int = 1
    title: str = ""

    def markdown(self):
        lines = [f"| {' | '.join(cells)} |" for cells in [self.heads, *self.rows]]
        rule = "|".join(":--" if i < self.words else "--:" for i in range(len(self.heads)))
        title = f"### {self.title}\n\n" if self.title else ""
        return title + "\n".join([lines[0], f"|{rule}|", *lines[1:]]) + "\n"


def cells_of(row, columns):
    """Texts of a row. columns: (head, name of a column or function of a row, format or function)."""
    values = [what(row) if callable(what) else row[what] for _, what, _ in columns]
    forms = [form.format if isinstance(form, str) else form for *_, form in columns]
    return [form(value) if is_known(value) else "-" for form, value in zip(forms, values)]


def table(frame, columns, words=1, title=""):
    """A Table with a row for each row of the frame. columns: see cells_of."""
    return Table([head for head, *_ in columns], [cells_of(row, columns) for _, row in frame.iterrows()], words, title)
