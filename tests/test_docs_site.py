"""`make docs` builds the site without a warning, and it needs no network."""

import os
from pathlib import Path
import re
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    """With --strict, a link or an anchor that leads nowhere is a fault."""
    done = subprocess.run(
        [
            *(sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"),
            *("--site-dir", str(tmp_path)),
        ],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    told = done.stdout + done.stderr
    assert done.returncode == 0, told
    assert "WARNING" not in told
    for page in tmp_path.rglob("*.html"):
        loaded = re.findall(
            r"<(?:script|img|iframe)[^>]*\bsrc=\"([^\"]*)|"
            r"<link[^>]*rel=\"stylesheet\"[^>]*href=\"([^\"]*)",
            page.read_text(),
        )
        for address in filter(None, sum(loaded, ())):
            assert not re.match(r"(https?:)?//", address), (page, address)
    # What is made from the program is there, with its words.
    people = (tmp_path / "api" / "people.html").read_text()
    assert "Desired speed, in m/s" in people
    keys = (tmp_path / "scenario_reference.html").read_text()
    assert 'id="HumanConfig"' in keys
    assert "Desired speed, in m/s" in keys
    vectors = (tmp_path / "api" / "layout.html").read_text()
    assert "Y of the point to walk to, in W, in meters." in vectors
