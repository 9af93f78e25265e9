"""A browser, and the editor's page served to it."""

import asyncio

from _pytest.runner import runtestprotocol
import pytest

from tests.browser.driver import Editor, serve


def pytest_collection_modifyitems(items):
    for item in items:
        if "tests/browser" in str(item.path):
            item.add_marker(pytest.mark.slow)


def pytest_runtest_protocol(item, nextitem):
    """Repeats a test that failed, up to twice: frames come late at times.

    A browser that shares two processors with other tests answers whenever it
    can. What is broken fails each time.
    """
    hook = item.ihook
    hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for attempt in range(3):
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        if attempt == 2 or not any(report.failed for report in reports):
            break
    for report in reports:
        hook.pytest_runtest_logreport(report=report)
    hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


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
