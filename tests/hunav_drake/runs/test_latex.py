import re
import shutil
import subprocess

import pytest

from hunav_drake.runs.comparison.latex import PACKAGES, escaped, to_latex
from hunav_drake.runs.comparison.tables import Table

SPECIAL = r"my_planner 50% & #1 $x^2 {y} ~\z <a> 3 ± 0.1 m²"

TABLE = Table(
    f"crossing, {SPECIAL}",
    ("", SPECIAL, "paper", "unit"),
    (
        ("path_length", "14.97 ± 0.02", "15.20", "m"),
        ("obstacle_force_on_robot", "6.6e-07 ± 2.0e-08", "-0.25", "m/s²"),
        ("completed", "100.0 [34.2, 100.0]", "-", "%"),
        ("a rather long name " * 6, "1", "2", SPECIAL),
    ),
)


def unescaped(text):
    """Returns what LaTeX would print."""
    words = {
        r"\textbackslash{}": "\\",
        r"\textasciitilde{}": "~",
        r"\textasciicircum{}": "^",
        r"$<$": "<",
        r"$>$": ">",
        r"$\pm$": "±",
        r"$^2$": "²",
    }
    pattern = "|".join(map(re.escape, words))
    parts = re.split(f"({pattern})", text)
    plain = (words.get(p) or re.sub(r"\\([&%$#_{}])", r"\1", p) for p in parts)
    return "".join(plain)


@pytest.mark.parametrize("character", list(r"_%&#${}~^\<>±²"))
def test_each_special_character_is_escaped(character):
    text = escaped(f"a{character}b")
    assert text != f"a{character}b"
    assert unescaped(text) == f"a{character}b"


def test_nothing_bare_is_left_in_a_table():
    text = to_latex(TABLE)
    body = [line for line in text.splitlines() if line.endswith(r"\\")]
    assert len(body) == 5
    # A row has as many columns as the table.
    assert {len(re.findall(r"(?<!\\)&", line)) for line in body} == {3}
    for line in body:
        assert not re.search(r"(?<!\\)[%#_]", line)
        # Mathematics begins and ends.
        assert len(re.findall(r"(?<!\\)\$", line)) % 2 == 0
    assert r"6.6$\times10^{-7}$ $\pm$ 2.0$\times10^{-8}$" in text
    assert "$-$0.25" in text
    assert r"100.0 [34.2, 100.0] & - & \%" in text


def test_it_compiles_and_is_no_wider_than_a_line(tmp_path):
    compiler = shutil.which("pdflatex")
    if compiler is None:
        pytest.skip("no pdflatex on the path")
    (tmp_path / "tables.tex").write_text(to_latex(TABLE))
    (tmp_path / "main.tex").write_text(
        r"\documentclass{article}"
        rf"\usepackage{{{','.join(PACKAGES)}}}"
        r"\begin{document}\input{tables.tex}\end{document}"
    )
    command = [compiler, "-interaction=nonstopmode", "-halt-on-error"]
    result = subprocess.run(
        [*command, "main.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=120,
        check=False,
    )
    if "booktabs.sty' not found" in result.stdout:
        pytest.skip("LaTeX has no booktabs here")
    assert result.returncode == 0, result.stdout
    assert (tmp_path / "main.pdf").stat().st_size > 1000
    assert "Overfull" not in result.stdout


@pytest.mark.parametrize("name", ["[m]", "*m"])
def test_no_name_of_a_row_is_an_option_of_the_line_before(name):
    lines = to_latex(Table("", ("", "dwb", "unit"), ((name, "1", "m"),)))
    assert f"\n{{}}{name} & 1 & m \\\\\n" in lines


def test_a_caption_has_no_paragraphs():
    assert escaped("one\n\n two") == "one two"
