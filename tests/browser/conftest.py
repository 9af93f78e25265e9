"""A browser, and the editor's page served to it."""

import asyncio
import shutil

import pytest

from tests.browser.driver import Editor, serve

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")


def pytest_collection_modifyitems(items):
    for item in items:
        if "tests/browser" in str(item.path):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def browser():
    pytest.importorskip("tornado", reason="the extra `editor` is not here")
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="there is no Playwright"
    )
    if BROWSER is None:
        pytest.skip("there is no Chromium on this machine")
    with playwright.sync_playwright() as start:
        found = start.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox"]
        )
        yield found
        found.close()


@pytest.fixture
def open_editor(browser, tmp_path):
    """Opens the editor of a text, a file or nothing; checks it in the end."""
    opened = []

    def start(text=None, *, filename="scene.yaml", view=None, **options):
        if text is not None:
            path = tmp_path / filename
            path.write_text(text)
            options["filename"] = path
        options.setdefault("folder", tmp_path)
        server = serve(**options)
        editor = Editor(browser, server, **(view or {}))
        opened.append(editor)
        return editor

    yield start
    for editor in opened:
        editor.close()
    for editor in opened:
        assert editor.complaints == []
        assert editor.strangers == set()
    # Playwright has a loop of its own; what is left of ours is closed.
    asyncio.set_event_loop(None)
