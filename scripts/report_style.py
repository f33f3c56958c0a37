# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""How the report looks: its style sheet. Wide windows have a contents column, narrow ones show each row of a table as a
block of names and values, so that no table is wider than its column."""

BASE = """
:root { color-scheme: light dark; --ink: #1c2733; --soft: #5b6875; --page: #ffffff; --panel: #f5f7f9; --line: #d9dee4;
        --good: #18794e; --bad: #b42318; --accent: #0072B2; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe6ee; --soft: #9aa7b4; --page: #14191f; --panel: #1c232b; --line: #36404b;
          --good: #4cc38a; --bad: #ff8b7d; --accent: #6db8ee; } }
* { box-sizing: border-box; }
html { scroll-padding-top: 1rem; }
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 112rem; margin: 0 auto; padding: 1.5rem 1.2rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .2rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .4rem; padding-top: .8rem; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
h4 { font-size: .92rem; margin: 1rem 0 -.4rem; }
p { margin: .4rem 0 .8rem; max-width: 52rem; }
sup { font-size: .72em; line-height: 0; }
.soft, figcaption, .reason { color: var(--soft); font-size: .87rem; }
a { color: var(--accent); }
.results { display: grid; gap: .8rem; margin: 1rem 0; max-width: 84rem; }
.results p { margin: 0; padding: .7rem .9rem; background: var(--panel); border: 1px solid var(--line); border-radius: 8px; }
.results b.figure { display: block; font-size: 1.55rem; line-height: 1.25; color: var(--accent); }
nav { font-size: .92rem; margin: 1.2rem 0 0; }
nav b { display: block; margin: .7rem 0 .1rem; color: var(--soft); font-weight: 600; }
nav div { display: flex; flex-wrap: wrap; gap: .2rem .9rem; }
.charts, .pictures { display: grid; gap: 1rem; margin: .8rem 0; }
.charts { grid-template-columns: repeat(auto-fit, minmax(min(100%, 21rem), 1fr)); align-items: start; }
.charts.one { grid-template-columns: minmax(0, 84rem); }
.pictures { grid-template-columns: repeat(auto-fit, minmax(min(100%, 15rem), 1fr)); }
.pictures.three { grid-template-columns: repeat(3, minmax(0, 1fr)); }
figure { margin: 0; background: var(--panel); border: 1px solid var(--line); border-radius: 8px; padding: .6rem; min-width: 0; }
figure img { display: block; width: 100%; height: auto; border-radius: 4px; }
figcaption { padding: .45rem .1rem 0; overflow-wrap: anywhere; }
figcaption b { color: var(--ink); }
.reason { display: block; margin: .3rem 0 0; }
code { font: .82rem/1.5 ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
.table { overflow-x: auto; margin: .8rem 0; border: 1px solid var(--line); border-radius: 8px; width: fit-content; max-width: 100%; }
.tables { display: flex; flex-wrap: wrap; gap: 0 1rem; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .6rem; text-align: right; border-bottom: 1px solid var(--line); }
td { white-space: nowrap; }
th { background: var(--panel); font-weight: 600; vertical-align: bottom; line-height: 1.25; }
tr:last-child td { border-bottom: 0; }
td.text { white-space: normal; overflow-wrap: break-word; }
td:first-child, td.text, th:first-child, th.text { text-align: left; }
th.group { text-align: center; border-left: 1px solid var(--line); } th.group:empty { border-left: 0; }
@media (min-width: 82rem) { .many td.text:first-child { min-width: 8.2rem; } }
.grouped { font-size: .85rem; } .grouped th, .grouped td { padding: .3rem .25rem; } .grouped .heads { display: none; }
.compact { font-size: .87rem; } .compact th, .compact td { padding: .3rem .3rem; }
.yes { color: var(--good); font-weight: 600; } .no { color: var(--bad); font-weight: 600; } .none { color: var(--soft); }
.missing { background: var(--panel); border: 1px dashed var(--line); border-radius: 8px; padding: .8rem 1rem; color: var(--soft); }
.entry { white-space: nowrap; margin-right: .7em; }
.key { display: inline-block; width: .8em; height: .8em; border-radius: 2px; margin-right: .3em; vertical-align: -.05em;
       border: 1px solid var(--line); }
details > summary { cursor: pointer; color: var(--accent); }
details.made { margin: .6rem 0 0; font-size: .87rem; } details.made > summary { color: var(--soft); }
details.made code { display: block; margin: .3rem 0; color: var(--soft); }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; font-size: .92rem; margin: .8rem 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
@media (min-width: 44rem) { .results { grid-template-columns: repeat(3, minmax(0, 1fr)); } }
@media (min-width: 82rem) {
  main { display: grid; grid-template: "contents head" auto "contents body" 1fr / 12.5rem minmax(0, 1fr); column-gap: 2.2rem; }
  header { grid-area: head; } .body { grid-area: body; }
  nav { grid-area: contents; position: sticky; top: 0; align-self: start; max-height: 100vh; overflow-y: auto; margin: 0;
        padding: .2rem 0 1rem; }
  nav div { display: block; } nav div a { display: block; padding: .1rem 0; } }
@media (max-width: 34rem) {
  body { font-size: 15px; } h1 { font-size: 1.35rem; } main { padding: 1rem .7rem 3rem; }
  .compact { font-size: .8rem; } .compact th, .compact td { padding: .25rem .2rem; }
  .pictures.three { grid-template-columns: minmax(0, 1fr); } figure { padding: .4rem; }
  dl { display: block; } dd { margin: 0 0 .5rem; } }
"""

# A row is a block of names and values.
STACKED = """
  WHICH, WHICH tbody { display: block; } WHICH thead { display: none; }
  WHICH tr { display: block; padding: .5rem .6rem; border-bottom: 1px solid var(--line); }
  WHICH td { display: flex; justify-content: space-between; gap: 1rem; border: 0; padding: .1rem 0; white-space: normal;
             text-align: right; }
  WHICH td:first-child { text-align: left; font-weight: 600; }
  WHICH td[data-name]::before { content: attr(data-name); color: var(--soft); font-weight: 400; text-align: left; }
"""

# A group of columns is a line.
GROUPS_STACKED = """
  .grouped, .grouped tbody { display: block; } .grouped thead { display: none; }
  .grouped tr { display: grid; grid-template-columns: minmax(0, 1fr) repeat(var(--columns), minmax(2.4rem, max-content));
                gap: .1rem .5rem; padding: .5rem .6rem; border-bottom: 1px solid var(--line); }
  .grouped td, .grouped .heads { display: contents; } .grouped td:first-child > span:first-child { font-weight: 600; }
  .grouped .heads span { text-align: right; color: var(--soft); }
  .grouped td[data-name]::before { content: attr(data-name); grid-column-start: 1; color: var(--soft); text-align: left; }
"""


def narrow(width, *rules):
    """Rules for windows up to a width; there tables take all of it."""
    return f"@media (max-width: {width}) {{ .table {{ width: 100%; }}" + "".join(rules) + "}\n"


STYLE = (
    BASE
    + narrow("34rem", STACKED.replace("WHICH", ".plain"))
    + narrow("64rem", STACKED.replace("WHICH", ".many"), GROUPS_STACKED)
)
