"""The parts of a report: text, tables and figures as HTML."""

from collections.abc import Callable, Iterable, Sequence
import html
import io
import re
from typing import TYPE_CHECKING
import warnings

from hunav_drake.results.quantity_text import number_text, superscript

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# For the eye: dark on white, tables with thin lines, as wide as text is easy
# to read; on paper without the frames of the screen.
_STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 3rem; max-width: 68rem;
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "Noto Sans",
  "DejaVu Sans", sans-serif; color: #1d2430; background: #fff; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .25rem; }
h3 { font-size: 1rem; margin: 1.5rem 0 .6rem; }
h2 { font-size: 1.15rem; margin: 2.25rem 0 .75rem; padding-bottom: .25rem;
  border-bottom: 1px solid #d5dae1; }
p { margin: .4rem 0; max-width: 46rem; }
a { color: #0059a3; }
.about { color: #525c69; }
.ended { margin: 1rem 0; padding: .6rem .9rem; border-left: 4px solid #888;
  background: #f5f7f9; max-width: none; }
.ended.goal { border-color: #009e73; }
.ended.timeout { border-color: #e69f00; }
.ended.stuck { border-color: #d55e00; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; line-height: 1.35; }
th, td { padding: .22rem .7rem .22rem 0; text-align: left;
  vertical-align: baseline; border-bottom: 1px solid #e8ebef; }
thead th { border-bottom: 1px solid #9aa4b0; vertical-align: bottom; }
th { font-weight: 600; }
tbody th { font-weight: 400; }
.wide tbody th { white-space: nowrap; }
tr.family th { padding-top: .8rem; font-weight: 600; color: #525c69; }
td.number, th.number { text-align: right;
  font-variant-numeric: tabular-nums; }
td.number { white-space: nowrap; }
details { margin: 1rem 0; }
summary { cursor: pointer; color: #0059a3; }
small { color: #525c69; font-size: .85em; }
.columns { columns: 26rem 2; column-gap: 2.5rem; }
.columns table { width: 100%; break-inside: avoid; margin-bottom: .9rem; }
.columns caption { text-align: left; font-weight: 600; color: #525c69;
  padding: .1rem 0; border-bottom: 1px solid #9aa4b0; }
.columns td:last-child { width: 4rem; }
.figures { columns: 22rem 2; column-gap: 2.5rem; }
.bars { display: grid; gap: 1rem 1.5rem; align-items: start;
  grid-template-columns: repeat(auto-fill, minmax(min(17rem, 100%), 1fr)); }
figure { margin: 0 0 1.5rem; break-inside: avoid; }
.bars figure { margin: 0; }
figure svg text { font-family: "DejaVu Sans", Verdana, system-ui, "Noto Sans",
  sans-serif !important; }
figure svg { display: block; width: 100%; max-width: 27rem; height: auto; }
figcaption { color: #525c69; font-size: .85rem; line-height: 1.4;
  margin-top: .3rem; max-width: 27rem; }
.provenance td { overflow-wrap: anywhere;
  font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .8rem; }
@media print {
  @page { margin: 16mm 14mm; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  .columns { columns: 2; column-gap: 8mm; }
  .figures { columns: 2; column-gap: 8mm; }
  .bars { grid-template-columns: repeat(3, 1fr); }
  .wide { overflow: visible; }
  .wide table { font-size: 7.5pt; }
  h2, h3 { break-after: avoid; }
  tr { break-inside: avoid; }
  .ended { background: none; }
}
"""


def escape(value: object) -> str:
    """Returns any text such that a page shows it as it is."""
    return html.escape(str(value), quote=True)


def page(title: str, parts: Iterable[str]) -> str:
    """Returns a page that needs nothing else, no network and no scripts."""
    body = "\n".join(part for part in parts if part)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,'
        ' initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n"
        f"</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str] | str],
    *,
    numbers: Iterable[int] = (),
    caption: str = "",
    kind: str = "",
) -> str:
    """Returns a table.

    Args:
        head: The headings, as HTML; none for a table without.
        rows: The cells of each row, as HTML, the first of which is its
            heading; or the text of a line that stands above some rows.
        numbers: The columns that hold numbers.
        caption: What is written above, as HTML.
        kind: The class of the table.
    """
    right = set(numbers)

    def cell(tag: str, i: int, text: str, scope: str = "") -> str:
        kind = ' class="number"' if i in right else ""
        return f"<{tag}{scope}{kind}>{text}</{tag}>"

    lines = [f'<table class="{kind}">' if kind else "<table>"]
    if caption:
        lines.append(f"<caption>{caption}</caption>")
    if head:
        cells = "".join(
            cell("th", i, text, ' scope="col"') for i, text in enumerate(head)
        )
        lines.append(f"<thead><tr>{cells}</tr></thead>")
    lines.append("<tbody>")
    for row in rows:
        if isinstance(row, str):
            span = max(len(head), 1)
            lines.append(
                f'<tr class="family"><th colspan="{span}">{row}</th></tr>'
            )
            continue
        cells = cell("th", 0, row[0], ' scope="row"') + "".join(
            cell("td", i, text) for i, text in enumerate(row[1:], 1)
        )
        lines.append(f"<tr>{cells}</tr>")
    return "\n".join([*lines, "</tbody></table>"])


def wide(text: str) -> str:
    """Returns a table that scrolls where it is wider than the page."""
    return f'<div class="wide">{text}</div>'


def number(value: float, unit: str = "", *, scale: float = 0.0) -> str:
    """Returns what `number_text` does, as HTML; a dash for NaN."""
    text = number_text(value, unit, scale=scale)
    if text == "-":
        return "&ndash;"
    mantissa, power, exponent = text.partition("e")
    if power:
        mantissa += f"&times;10{superscript(str(int(exponent)))}"
    return mantissa.replace("inf", "&infin;").replace("-", "&minus;")


def figure(
    name: str,
    caption: str,
    size: tuple[float, float],
    draw: Callable[["Axes"], object],
    *,
    layout: str = "constrained",
    captioned: bool = True,
) -> str:
    """Returns a drawing as a figure, with its picture inside.

    Args:
        name: A name that no other figure of the page has, of letters, digits
            and "-".
        caption: What is to be seen, as text.
        size: Width and height, in inches.
        draw: Draws on the axes that it is given.
        layout: The layout of Matplotlib.
        captioned: Whether all see the caption, or only who cannot see the
            picture.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from hunav_drake.plots.style import set_text_sizes

    # Text stays text, so that the browser finds a font for any script; and the
    # same drawing is the same text.
    settings = {"svg.fonttype": "none", "svg.hashsalt": name}
    with mpl.rc_context(settings), warnings.catch_warnings():
        # Only the size of such a letter is not known here.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        drawing = Figure(figsize=size, layout=layout)
        ax = drawing.subplots()
        set_text_sizes(ax)
        draw(ax)
        stream = io.StringIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        drawing.savefig(stream, format="svg", metadata=nothing)
    picture = _inline(stream.getvalue(), name, caption)
    below = f"<figcaption>{escape(caption)}</figcaption>\n" * captioned
    return f"<figure>\n{picture}\n{below}</figure>"


def _inline(svg: str, name: str, caption: str) -> str:
    """Returns a picture as a part of a page."""
    svg = svg[svg.index("<svg") :].strip()
    # A page knows these names by itself.
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg)
    # The names of groups are of no use, and would be those of other pictures.
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = re.sub(r'href="#', f'href="#{name}-', svg)
    svg = svg.replace("url(#", f"url(#{name}-")
    label = escape(caption)
    return svg.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
