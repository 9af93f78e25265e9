"""A browser, and the editor's page served to it."""

import asyncio
import gc

import pytest

from tests.browser.driver import Editor, serve


def pytest_collection_modifyitems(items):
    for item in items:
        if "tests/browser" in str(item.path):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(autouse=True)
def no_garbage():
    """Ends what earlier tests left: a Meshcat must end in its own thread.

    The editor has threads; if one of them collected it, Drake would abort.
    """
    gc.collect()


@pytest.fixture(scope="module")
def worker():
    """The process that runs trials, one for the tests of a file."""
    from hunav_drake.editor.worker import Worker

    own = Worker()
    own.start()
    yield own
    own.close()


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
