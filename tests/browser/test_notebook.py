"""The widget in JupyterLab, driven as a user does."""

from importlib.util import find_spec
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request

import pytest

for extra in ("anywidget", "jupyterlab"):
    # (Importing them takes seconds.)
    if find_spec(extra) is None:
        pytest.skip(f"there is no {extra}", allow_module_level=True)

PATIENCE = 300
SCENE = """\
world:
  walls: [{type: box, center: [0, 4], size: [10, 0.2]}]
humans:
  # who comes first
  - {name: alba, pose: [-3, 0, 0], goals: [[2, 0]]}
  - {name: bruno, pose: [-3, 2, 0], goals: [[1, 2]]}
robot: {start: [-2, -2, 0], goal: [3, -2, 0]}
"""


def _cell(source):
    return {
        "cell_type": "code",
        "execution_count": None,
        "id": f"c{abs(hash(source)) % 10**8}",
        "metadata": {},
        "outputs": [],
        "source": source,
    }


NOTEBOOK = {
    "cells": [
        _cell(
            "from hunav_drake import EditScenario\n"
            "editor = EditScenario('scene.yaml')\n"
            "editor"
        ),
        _cell("print('x of bruno:', editor.scenario.humans[1].pose[0])"),
        _cell("# the last cell"),
    ],
    "metadata": {
        "kernelspec": {
            "display_name": "Python 3",
            "language": "python",
            "name": "python3",
        }
    },
    "nbformat": 4,
    "nbformat_minor": 5,
}


@pytest.fixture
def lab(tmp_path):
    """A JupyterLab of its own; its address."""
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "edit.ipynb").write_text(json.dumps(NOTEBOOK))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    folders = {
        name: str(tmp_path / "jupyter" / name)
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "IPYTHONDIR")
    }
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "jupyterlab", "--no-browser"),
            *(f"--port={port}", "--IdentityProvider.token=secret"),
            *("--ip=127.0.0.1", "--allow-root", f"--notebook-dir={tmp_path}"),
        ],
        env={**os.environ, **folders, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    address = f"http://127.0.0.1:{port}"
    end = time.monotonic() + PATIENCE
    while True:
        try:
            urllib.request.urlopen(f"{address}/api?token=secret").close()
            break
        except OSError:
            assert process.poll() is None, "JupyterLab has ended"
            assert time.monotonic() < end, "JupyterLab does not answer"
            time.sleep(0.2)
    yield address
    os.killpg(process.pid, signal.SIGTERM)
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.mark.skipif(
    shutil.which("chromium") is None, reason="there is no Chromium"
)
def test_the_editor_in_a_cell(lab, browser, tmp_path):
    context = browser.new_context(viewport={"width": 1500, "height": 1300})
    page = context.new_page()
    page.set_default_timeout(1000 * PATIENCE)
    errors, strangers = [], set()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on(
        "request",
        lambda it: (
            None
            if it.url.startswith((lab, "data:", "blob:", "ws:"))
            else strangers.add(it.url)
        ),
    )
    page.goto(f"{lab}/lab/tree/edit.ipynb?token=secret&reset")
    page.locator(".jp-Notebook .jp-Cell").first.wait_for()
    # Before the kernel is there, cells are not run.
    page.get_by_text("| Idle").wait_for()
    _run_cell(page, 0)
    page.locator(".hunav-editor .map [data-key='humans/1']").wait_for()
    page.wait_for_timeout(500)

    # Bruno is dragged 2 m to the right, and the scenario is another one.
    begin, end = _pixels(page, -3, 2), _pixels(page, -1, 2)
    page.mouse.move(*begin)
    page.mouse.down()
    page.mouse.move(*end, steps=5)
    page.mouse.up()
    _wait_for_bruno(page, -1.0)

    # Keys are for the map: cells stay, and Ctrl+Z is the editor's.
    cells = page.locator(".jp-Notebook .jp-Cell").count()
    page.mouse.click(*_pixels(page, -3, 0))
    page.locator(".hunav-editor [data-key='humans/0'].selected").wait_for()
    page.keyboard.press("Delete")
    page.locator(".hunav-editor [data-key='humans/1']").wait_for(
        state="detached"
    )
    page.keyboard.press("Control+z")
    page.locator(".hunav-editor [data-key='humans/1']").wait_for()
    page.keyboard.press("Control+z")
    _wait_for_bruno(page, -3.0)
    assert page.locator(".jp-Notebook .jp-Cell").count() == cells
    sources = page.locator(".jp-Cell .cm-content").all_inner_texts()
    assert "EditScenario" in sources[0]
    # Nothing is written unasked.
    assert (tmp_path / "scene.yaml").read_text() == SCENE

    # A run, and its report, which stands apart from the notebook.
    page.locator(".hunav-editor .chip").nth(3).wait_for(state="attached")
    page.locator(".hunav-editor header .primary").click()
    page.locator(".run-links .link", has_text="Report").click()
    frame = page.frame_locator(".result-dialog iframe")
    frame.locator("h1").first.wait_for()
    assert frame.locator("h1").first.evaluate("() => window.origin") == "null"
    page.locator(".result-dialog button").click()
    if folder := os.environ.get("HUNAV_SCREENSHOTS"):
        page.screenshot(path=f"{folder}/jupyterlab.png")
    assert errors == []
    assert strangers == set()
    context.close()


def _run_cell(page, index):
    page.locator(".jp-Cell .cm-content").nth(index).click()
    page.keyboard.press("Control+Enter")


def _wait_for_bruno(page, x):
    """Waits until Bruno's place has come to the kernel."""
    end = time.monotonic() + PATIENCE
    while (now := _x_of_bruno(page)) != x:
        assert time.monotonic() < end, now


def _x_of_bruno(page):
    """Runs the second cell, and returns what it prints."""
    output = page.locator(".jp-Cell").nth(1).locator(".jp-OutputArea-output")
    page.locator(".jp-Cell .cm-content").nth(1).click()
    page.keyboard.press("Escape")
    before = page.locator(".jp-Cell").nth(1).inner_text()
    count = re.search(r"\[(\d+)\]", before)
    page.keyboard.press("Control+Enter")
    end = time.monotonic() + PATIENCE
    while True:
        assert time.monotonic() < end, "the cell has no output"
        now = page.locator(".jp-Cell").nth(1).inner_text()
        found = re.search(r"\[(\d+)\]", now)
        if found and (count is None or found[1] != count[1]) and output.count():
            return float(output.first.inner_text().split(":")[1])
        page.wait_for_timeout(100)


def _pixels(page, x, y):
    return page.evaluate(
        """([x, y]) => {
          const world = document.querySelector(".map .base .world");
          const m = world.getScreenCTM();
          return [m.a * x + m.e, m.d * y + m.f];
        }""",
        [x, y],
    )
