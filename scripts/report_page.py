# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""HTML of the report: one file without references to others."""

import base64
import re
from html import escape

from report_style import STYLE

MANY = 6  # columns of a table that narrow windows, too, show as blocks


def data_url(kind, content):
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def chart(pictures, text, on_phones=None, caption=""):
    """pictures: as report_figures.themed makes them. text: for readers who do not see it. on_phones: other pictures for
    there. caption: HTML."""
    sources = []
    for found, media in ((on_phones, " and (max-width: 34rem)"), (pictures, "")):
        if found:
            for theme in ("dark", "light"):
                url = data_url("image/svg+xml", found[theme])
                sources.append(f'<source media="(prefers-color-scheme: {theme}){media}" srcset="{url}">')
    last = data_url("image/svg+xml", pictures["light"])
    caption = f"<figcaption>{caption}</figcaption>" if caption else ""
    return f'<figure><picture>{"".join(sources[:-1])}<img src="{last}" alt="{escape(text)}"></picture>{caption}</figure>'


def charts(parts):
    """Side by side, none wider than is good for it."""
    return f'<div class="charts" style="max-width: {34 * len(parts)}rem">{"".join(parts)}</div>'


def image(content, caption, text, kind="webp"):
    """caption: HTML."""
    return (
        f'<figure><img src="{data_url("image/" + kind, content)}" alt="{escape(text)}" loading="lazy">'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def missing(what):
    return f'<p class="missing">No data: {escape(what)}</p>'


def is_empty(html):
    """Whether a section shows nothing that was measured."""
    return "No data: " in html and not any(tag in html for tag in ("<table", "<picture", "<img", "<svg"))


def folded(title, body, kind=""):
    """body: HTML."""
    return f'<details{kind}><summary>{escape(title)}</summary>{body}</details>' if body else ""


def label(name):
    """cLEAF^2 with the frame level raised."""
    kind, _, frame = name.partition("^")
    return escape(kind) + (f"<sup>{escape(frame)}</sup>" if frame else "")


def raised(text):
    """Words in which frame levels are raised: cLEAF^2."""
    return re.sub(r"\^(\w+)", r"<sup>\1</sup>", escape(text))


def table(heads, rows, text_columns=(0,), compact=False):
    """heads and rows: HTML. text_columns: of words, aligned left, which may take several lines. compact: its columns are
    few and narrow enough for a phone."""
    kinds = ["text" if i in text_columns else "" for i in range(len(heads))]
    shape = "compact" if compact else "plain many" if len(heads) >= MANY else "plain"
    out = [f'<div class="table"><table class="{shape}"><thead><tr>']
    out += [f'<th class="{kind}">{head}</th>' for kind, head in zip(kinds, heads)]
    out.append("</tr></thead><tbody>")
    for row in rows:
        cells = [
            f'<td class="{kind}"' + (f' data-name="{plain(head)}"' if i else "") + f"><span>{cell}</span></td>"
            for i, (kind, head, cell) in enumerate(zip(kinds, heads, row))
        ]
        out.append("<tr>" + "".join(cells) + "</tr>")
    return "".join(out) + "</tbody></table></div>"


def plain(head):
    """A head as an attribute: frame levels after a caret, no other tags."""
    for tag, text in (("<b>", ""), ("</b>", ""), ("<sup>", "^"), ("</sup>", "")):
        head = head.replace(tag, text)
    return head.replace('"', "&quot;")


def grouped_table(groups, heads, rows):
    """Columns in groups that have the same heads; a group is a line on phones. groups: their names. heads: of the columns
    of each. rows: the name of a row and its cells, group by group, as HTML."""
    out = [f'<div class="table"><table class="grouped" style="--columns: {len(heads)}"><thead><tr><th></th>']
    out += [f'<th class="group" colspan="{len(heads)}">{escape(group)}</th>' for group in groups]
    out += ["</tr><tr><th></th>"] + [f"<th>{head}</th>" for head in heads] * len(groups) + ["</tr></thead><tbody>"]
    on_phones = '<span class="heads">' + "".join(f"<span>{head}</span>" for head in heads) + "</span>"
    for name, cells in rows:
        out.append(f"<tr><td><span>{name}</span>{on_phones}</td>")
        for i, cell in enumerate(cells):
            group = f' data-name="{escape(groups[i // len(heads)])}"' if i % len(heads) == 0 else ""
            out.append(f"<td{group}><span>{cell}</span></td>")
        out.append("</tr>")
    return "".join(out) + "</tbody></table></div>"


def section(name, title, *parts, commands=()):
    """commands: that measured what it shows, folded at its end."""
    made_by = "".join(f"<code>{escape(command)}</code>" for command in dict.fromkeys(commands))
    return (
        f'<section><h2 id="{name}">{escape(title)}</h2>'
        + "".join(parts)
        + folded("Made by", made_by, ' class="made"')
        + "</section>"
    )


def page(title, head, groups):
    """head: HTML of the first screen. groups: {title: {name of a section: (its text in the contents, its HTML)}}."""
    links, bodies = [], []
    for group, sections in groups.items():
        links.append(f"<b>{escape(group)}</b><div>")
        links += [f'<a href="#{name}">{escape(text)}</a>' for name, (text, _) in sections.items()]
        links.append("</div>")
        bodies += [body for _, body in sections.values()]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body><main>"
        f'<header><h1>{escape(title)}</h1>{head}</header><nav aria-label="Contents">{"".join(links)}</nav>'
        f'<div class="body">' + "\n".join(bodies) + "</div></main></body></html>\n"
    )
