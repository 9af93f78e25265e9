"""`make docs` builds the site without a warning, and it needs no network."""

import os
from pathlib import Path
import re
import subprocess
import sys
import tomllib

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path, browser):
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
    for page in (tmp_path / "api").glob("*.html"):
        text = re.sub("<[^>]*>", "", page.read_text())
        assert not re.search(r"::\s*$", text, re.M), page
    robots = (tmp_path / "api" / "robot.html").read_text()
    assert "<span>velocity_command</span>" in robots
    search(browser, tmp_path)


def search(browser, site):
    """Searches in the site as opened from a file; nothing is asked of a net."""
    page = browser.new_page()
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto((site / "own_metric.html").as_uri())
    page.locator("input[name=query]").press_sequentially("curious")
    page.wait_for_selector(".md-search-result__item")
    page.click(".md-search-result__item a >> nth=0")
    page.wait_for_url(re.compile(r"/behaviors\.html"))
    page.close()
    assert {url.split(":")[0] for url in asked} <= {"file", "data", "about"}


def test_one_version_and_one_address_everywhere():
    """Of the package: pyproject, citation, change log, site and README."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    version, urls = project["version"], project["urls"]
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert str(cited["version"]) == version
    assert cited["repository-code"] == urls["Repository"]
    assert cited["url"] == urls["Documentation"]
    changes = (ROOT / "CHANGELOG.md").read_text()
    (newest, day), *_ = re.findall(r"^## (\S+) \((.*)\)$", changes, re.M)
    assert (newest, day) == (version, str(cited["date-released"]))
    site = (ROOT / "mkdocs.yml").read_text()
    assert f"repo_url: {urls['Repository']}\n" in site
    readme = (ROOT / "README.md").read_text()
    assert f"pip install {project['name']}" in readme
    assert urls["Documentation"] in readme
