# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""HTML of the report: one file without references to others."""

import base64
from html import escape

STYLE = """
:root { color-scheme: light dark; --ink: #1c2733; --soft: #5b6875; --page: #ffffff; --panel: #f5f7f9; --line: #d9dee4;
        --good: #18794e; --bad: #b42318; --accent: #0072B2; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe6ee; --soft: #9aa7b4; --page: #14191f; --panel: #1c232b; --line: #36404b;
          --good: #4cc38a; --bad: #ff8b7d; --accent: #6db8ee; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 76rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .4rem; padding-top: .8rem; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
h4 { font-size: .92rem; margin: 1rem 0 -.4rem; }
p { margin: .4rem 0 .8rem; max-width: 52rem; }
.soft, figcaption, .command, .reason { color: var(--soft); font-size: .87rem; }
nav { display: flex; flex-wrap: wrap; gap: .3rem .9rem; margin: .8rem 0 0; font-size: .92rem; }
a { color: var(--accent); }
.charts, .pictures { display: grid; gap: 1rem; margin: .8rem 0; }
.charts { grid-template-columns: repeat(auto-fit, minmax(min(100%, 21rem), 1fr)); }
.pictures { grid-template-columns: repeat(auto-fit, minmax(min(100%, 15rem), 1fr)); }
.pictures.three { grid-template-columns: repeat(3, minmax(0, 1fr)); }
figure { margin: 0; background: var(--panel); border: 1px solid var(--line); border-radius: 8px; padding: .6rem; min-width: 0; }
figure img { display: block; width: 100%; height: auto; border-radius: 4px; }
figcaption { padding: .45rem .1rem 0; overflow-wrap: anywhere; }
figcaption b { color: var(--ink); }
.command, .reason { display: block; margin: .3rem 0 0; }
code { font: .82rem/1.5 ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
.table { overflow-x: auto; margin: .8rem 0; border: 1px solid var(--line); border-radius: 8px; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .6rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
tr:last-child td { border-bottom: 0; }
th { background: var(--panel); font-weight: 600; }
th.group { text-align: center; border-left: 1px solid var(--line); } th.group:empty { border-left: 0; }
th:first-child, td:first-child, td.text, th.text { text-align: left; }
.grouped { font-size: .85rem; } .grouped th, .grouped td { padding: .3rem .35rem; } .grouped .heads { display: none; }
td.wrap { white-space: normal; min-width: 13rem; }
.yes { color: var(--good); font-weight: 600; } .no { color: var(--bad); font-weight: 600; } .none { color: var(--soft); }
.missing { background: var(--panel); border: 1px dashed var(--line); border-radius: 8px; padding: .8rem 1rem; color: var(--soft); }
.entry { white-space: nowrap; margin-right: .7em; }
.key { display: inline-block; width: .8em; height: .8em; border-radius: 2px; margin-right: .3em; vertical-align: -.05em;
       border: 1px solid var(--line); }
details > summary { cursor: pointer; color: var(--accent); }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; font-size: .92rem; margin: .8rem 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 34rem) {
  body { font-size: 15px; } h1 { font-size: 1.35rem; } main { padding: 1rem .7rem 3rem; }
  .pictures.three { grid-template-columns: minmax(0, 1fr); } figure { padding: .4rem; }
  .stack thead { display: none; } .stack tr { display: block; padding: .5rem .6rem; border-bottom: 1px solid var(--line); }
  .stack td { display: flex; justify-content: space-between; gap: 1rem; border: 0; padding: .1rem 0; white-space: normal; text-align: right; }
  .stack td:first-child { text-align: left; font-weight: 600; }
  .stack td[data-name]::before { content: attr(data-name); color: var(--soft); font-weight: 400; text-align: left; }
  .grouped, .grouped tbody { display: block; } .grouped thead { display: none; }
  .grouped tr { display: grid; grid-template-columns: minmax(0, 1fr) repeat(var(--columns), minmax(2.4rem, max-content));
                gap: .1rem .5rem; padding: .5rem .6rem; border-bottom: 1px solid var(--line); }
  .grouped td, .grouped .heads { display: contents; } .grouped td:first-child > span:first-child { font-weight: 600; }
  .grouped .heads span { text-align: right; color: var(--soft); }
  .grouped td[data-name]::before { content: attr(data-name); grid-column-start: 1; color: var(--soft); text-align: left; } }
"""


def data_url(kind, content):
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def chart(pictures, text):
    """pictures: as report_figures.themed makes them. text: for readers who do not see it."""
    light, dark = (data_url("image/svg+xml", pictures[name]) for name in ("light", "dark"))
    return (
        f'<figure><picture><source media="(prefers-color-scheme: dark)" srcset="{dark}">'
        f'<img src="{light}" alt="{escape(text)}"></picture></figure>'
    )


def image(content, caption, text):
    """caption: HTML."""
    return (
        f'<figure><img src="{data_url("image/webp", content)}" alt="{escape(text)}" loading="lazy">'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def missing(what):
    return f'<p class="missing">No data: {escape(what)}</p>'


def command(*commands):
    return "".join(f'<span class="command">Made by <code>{escape(c)}</code></span>' for c in dict.fromkeys(commands))


def label(name):
    """cLEAF^2 with the frame level raised."""
    kind, _, frame = name.partition("^")
    return escape(kind) + (f"<sup>{escape(frame)}</sup>" if frame else "")


def table(heads, rows, text_columns=(0,), stack=False, wrap=False):
    """rows: lists of HTML. text_columns: aligned left. stack: cells one below the other on phones. wrap: cells of
    several lines."""
    kinds = ["text" if i in text_columns else "" for i in range(len(heads))]
    out = ['<div class="table"><table' + (' class="stack"' if stack else "") + "><thead><tr>"]
    out += [f'<th class="{kind}">{head}</th>' for kind, head in zip(kinds, heads)]
    out.append("</tr></thead><tbody>")
    for row in rows:
        cells = [
            f'<td class="{kind}{" wrap" if wrap else ""}"'
            + (f' data-name="{escape(head)}"' if stack and i else "")
            + f"><span>{cell}</span></td>"
            for i, (kind, head, cell) in enumerate(zip(kinds, heads, row))
        ]
        out.append("<tr>" + "".join(cells) + "</tr>")
    out.append("</tbody></table></div>")
    return "".join(out)


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


def section(name, title, *parts):
    return f'<section><h2 id="{name}">{escape(title)}</h2>' + "".join(parts) + "</section>"


def page(title, head, sections, contents):
    """contents: (name, text) of the sections, for the links at the top."""
    links = "".join(f'<a href="#{name}">{escape(text)}</a>' for name, text in contents)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body><main>"
        f"<h1>{escape(title)}</h1>{head}<nav>{links}</nav>" + "\n".join(sections) + "</main></body></html>\n"
    )
