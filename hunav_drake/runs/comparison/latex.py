"""Tables of a suite for LaTeX."""

import re

from hunav_drake.runs.comparison.tables import NOTE, Table

# The packages that a document needs.
PACKAGES = ("booktabs", "graphicx")

_SPECIAL = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "&": r"\&",
        "%": r"\%",
        "$": r"\$",
        "#": r"\#",
        "_": r"\_",
        "{": r"\{",
        "}": r"\}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "<": r"$<$",
        ">": r"$>$",
        "\N{PLUS-MINUS SIGN}": r"$\pm$",
        "\N{SUPERSCRIPT TWO}": r"$^2$",
        "\N{SUPERSCRIPT THREE}": r"$^3$",
        "\N{EN DASH}": "--",
    }
)


def to_latex(table: Table) -> str:
    """Returns a table for LaTeX, which needs `PACKAGES`.

    It is as wide as its text, but at most one line, and spans two columns.
    """
    columns = "l" + "r" * (len(table.header) - 2) + "l"
    head = " & ".join(map(escaped, table.header))
    caption = table.caption or f"{table.title}. {NOTE}"
    # (After a line, a bracket or an asterisk would be an option of its end.)
    rows = [
        re.sub(r"^(?=[\[*])", "{}", " & ".join(map(_cell, row))) + r" \\"
        for row in table.rows
    ]
    return "\n".join(
        [
            r"\begin{table*}",
            r"\centering\footnotesize\setlength{\tabcolsep}{3pt}",
            rf"\caption{{{escaped(caption)}}}",
            rf"\sbox0{{\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            *_groups(table),
            head + r" \\",
            r"\midrule",
            *rows,
            r"\bottomrule",
            r"\end{tabular}}%",
            r"\ifdim\wd0>\linewidth\resizebox{\linewidth}{!}{\usebox0}%",
            r"\else\usebox0\fi",
            r"\end{table*}",
            "",
        ]
    )


def _groups(table: Table) -> list[str]:
    """Returns the line of names above columns, with rules below them."""
    if not table.groups:
        return []
    cells, rules, first = [], [], 2
    for name, count in table.groups:
        cells.append(rf"\multicolumn{{{count}}}{{c}}{{{escaped(name)}}}")
        rules.append(rf"\cmidrule(lr){{{first}-{first + count - 1}}}")
        first += count
    return [f" & {' & '.join(cells)} & " + r"\\", "".join(rules)]


def escaped(text: str) -> str:
    """Returns text with the special characters of LaTeX escaped.

    Other characters need fontenc and inputenc, or XeLaTeX or LuaLaTeX.
    """
    # A caption must not have paragraphs.
    return re.sub(r"\s*\n\s*", " ", text).translate(_SPECIAL)


def _cell(text: str) -> str:
    """Returns escaped text, with minus signs and powers of ten."""
    text = escaped(text)
    text = re.sub(
        r"(?<=\d)e([+-]\d+)",
        lambda match: rf"$\times10^{{{int(match[1])}}}$",
        text,
    )
    return re.sub(r"(?<![\w.{^-])-(?=\d)", "$-$", text)
