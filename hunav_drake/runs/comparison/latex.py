"""Tables of a suite for LaTeX."""

import re

from hunav_drake.runs.comparison.tables import NOTE, Table

# What a document needs in its preamble.
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
    """Returns a table for LaTeX, with the packages of `PACKAGES`.

    It is as wide as its text, but at most as a line. In two columns it takes
    both.
    """
    columns = "l" + "r" * (len(table.header) - 2) + "l"
    head = " & ".join(map(escaped, table.header))
    rows = [" & ".join(map(_cell, row)) + r" \\" for row in table.rows]
    return "\n".join(
        [
            r"\begin{table*}",
            r"\centering\footnotesize\setlength{\tabcolsep}{3pt}",
            rf"\caption{{{escaped(f'{table.title}. {NOTE}')}}}",
            rf"\sbox0{{\begin{{tabular}}{{{columns}}}",
            r"\toprule",
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


def escaped(text: str) -> str:
    """Returns text in which nothing means anything to LaTeX.

    Characters that pdfLaTeX does not know are left to fontenc and inputenc, or
    to XeLaTeX and LuaLaTeX.
    """
    return text.translate(_SPECIAL)


def _cell(text: str) -> str:
    """Returns text, in which numbers have minus signs and powers of ten."""
    text = escaped(text)
    text = re.sub(
        r"(?<=\d)e([+-]\d+)",
        lambda match: rf"$\times10^{{{int(match[1])}}}$",
        text,
    )
    return re.sub(r"(?<![\w.{^-])-(?=\d)", "$-$", text)
