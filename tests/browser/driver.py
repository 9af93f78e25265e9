"""The editor as a user drives it: by places on the map, keys and fields."""

from contextlib import contextmanager
import threading
import time

# How long what is waited for may take on a machine that is busy, in seconds.
PATIENCE = 30

SMALL = """\
# Two people in a hall.
world:
  walls:
    - {type: box, name: north, center: [0, 4], size: [10, 0.2]}   # thick
    - {type: polyline, name: rail, points: [[-4, -3], [0, -3], [4, -3]]}
  furniture:
    - {type: table, name: desk, center: [3, 1.5], size: [1.2, 0.8]}
humans:
  # who comes first
  - name: alba
    pose: [-3, 0, 0]      # at the door
    behavior: regular
    goals:
      - [0, 0]
      - [2, 0]
  - name: bruno
    pose: [ -3, 2.0,0 ]
    desired_speed: 1.1
    goals: [[1, 2]]
robot:
  start: [-2, -2, 0]
  goal: [3, -2, 0]
"""


class Server:
    """A page that is served by a thread of its own."""

    def __init__(self, page, session):
        self.page = page
        self.session = session
        ready = threading.Event()
        self.thread = threading.Thread(
            target=page.run, args=[ready.set], daemon=True
        )
        self.thread.start()
        assert ready.wait(PATIENCE)

    def stop(self):
        self.page.stop()
        self.thread.join(PATIENCE)
        self.session.close()


def serve(*, linger=60, find_file=None, **options):
    from hunav_drake.editor.page import EditPage
    from hunav_drake.editor.session import EditSession

    session = EditSession(**options)
    page = EditPage(session, linger=linger, find_file=find_file)
    return Server(page, session)


class Editor:
    """One page with a browser context of its own."""

    def __init__(self, browser, server, width=1280, height=800, **options):
        self.server = server
        self.session = server.session
        self.complaints = []
        self.strangers = set()
        self.context = browser.new_context(
            viewport={"width": width, "height": height},
            reduced_motion="reduce",
            **options,
        )
        self.context.grant_permissions(["clipboard-read", "clipboard-write"])
        self.page = self.new_page()

    def new_page(self):
        page = self.context.new_page()
        page.set_default_timeout(1000 * PATIENCE)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", self._note)
        page.on("request", self._look)
        page.goto(self.server.page.url)
        page.wait_for_selector(".hunav-editor[data-ready]")
        return page

    def _note(self, message):
        if message.type in ("error", "warning"):
            self.complaints.append(message.text)

    def _look(self, request):
        own = f"http://127.0.0.1:{self.server.page.port}/"
        if not request.url.startswith((own, "data:", "blob:")):
            self.strangers.add(request.url)

    def restart(self, **options):
        """Serves anew what is in a file, to the same browser."""
        self.server.stop()
        self.server = serve(**options)
        self.session = self.server.session
        self.page = self.new_page()

    def close(self):
        self.context.close()
        self.server.stop()

    # Places

    def pixels(self, x, y):
        """Returns the pixels of a place in the world, in meters."""
        return self.page.evaluate(
            """([x, y]) => {
              const world = document.querySelector(".map .base .world");
              const m = world.getScreenCTM();
              return [m.a * x + m.e, m.d * y + m.f];
            }""",
            [x, y],
        )

    def world(self, px, py):
        """Returns the place in the world, in meters, of pixels."""
        return self.page.evaluate(
            """([x, y]) => {
              const world = document.querySelector(".map .base .world");
              const m = world.getScreenCTM();
              return [(x - m.e) / m.a, (y - m.f) / m.d];
            }""",
            [px, py],
        )

    def click(self, x, y, **options):
        self.page.mouse.click(*self.pixels(x, y), **options)

    def double_click(self, x, y):
        self.page.mouse.dblclick(*self.pixels(x, y))

    @contextmanager
    def pressed(self, x, y):
        """Holds the mouse button, from a place on."""
        self.page.mouse.move(*self.pixels(x, y))
        self.page.mouse.down()
        yield
        self.page.mouse.up()

    def drag(self, start, end, steps=4):
        with self.pressed(*start):
            self.page.mouse.move(*self.pixels(*end), steps=steps)

    def drag_handle(self, name, end):
        """Drags a handle of what is selected."""
        box = self.page.locator(f'[data-handle="{name}"] .grip').bounding_box()
        start = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(*self.pixels(*end), steps=4)
        self.page.mouse.up()

    def drop_at(self, end, *, steps=4):
        self.page.mouse.move(*self.pixels(*end), steps=steps)

    # Parts

    def part(self, key):
        return self.page.locator(f'.map [data-key="{key}"]')

    def field(self, name):
        return self.page.locator(f'.form:visible [data-field="{name}"]')

    def tool(self, name):
        self.page.locator(f'.tool-bar [data-tool="{name}"]').click()

    def tab(self, name):
        tab = self.page.locator(f'[role="tab"][data-tab="{name}"]')
        if tab.get_attribute("aria-selected") != "true":
            tab.click()

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)

    def tab_to(self, selector, *, back=False):
        """Goes on by the Tab key until what matches has the focus."""
        for _ in range(100):
            self.press("Shift+Tab" if back else "Tab")
            if self.page.evaluate(
                "selector => document.activeElement.matches(selector)", selector
            ):
                return
        raise AssertionError(f"Tab does not lead to {selector}")

    def focus_map(self):
        self.page.locator(".map").focus()

    # What has come of it

    def wait(self, what, seconds=PATIENCE):
        """Waits until something is true of the session, and returns it."""
        end = time.monotonic() + seconds
        while not (found := what(self.session)):
            assert time.monotonic() < end, self.session.text
            self.page.wait_for_timeout(20)
        return found

    def wait_for(self, path, value):
        """Waits until the data hold a value at a path."""
        self.wait(lambda session: at(session.data, path) == value)

    def expect(self, locator):
        """Returns Playwright's assertions, which wait until they hold."""
        from playwright.sync_api import expect

        expect.set_options(timeout=1000 * PATIENCE)
        return expect(locator)

    def metrics(self):
        """Returns the texts of the first column of the table of runs."""
        rows = self.page.locator(".run-table [data-metric]")
        cells = (
            "(it) => [it.dataset.metric, it.querySelector('td').textContent]"
        )
        return dict(rows.evaluate_all(f"rows => rows.map({cells})"))

    def settle(self):
        """Waits until no edit is on its way, and the page shows all of it."""
        self.wait(
            lambda it: (
                self.page.locator(".hunav-editor").get_attribute(
                    "data-revision"
                )
                == str(it.state.revision)
            )
        )

    def undo_all(self):
        for _ in range(100):
            button = self.page.locator(".step").first
            if button.is_disabled():
                return
            button.click()
            self.settle()


class SharedWorker:
    """A worker that outlives the sessions which use it."""

    def __init__(self, worker):
        self.worker = worker

    def __getattr__(self, name):
        return getattr(self.worker, name)

    def close(self):
        self.worker.cancel()


def at(data, path):
    """Returns the value at a path in plain data, or None."""
    for key in path:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def near(value, wanted, tolerance=0.051):
    """Tells whether numbers are where they should be, in meters."""
    return value is not None and all(
        abs(a - b) <= tolerance for a, b in zip(value, wanted, strict=True)
    )
