"""Turns a page, such as a recorded replay, into a picture."""

import base64
import gzip
from pathlib import Path
import re
import shutil
import subprocess
import tempfile
from typing import Any

import pytest

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None
)

# Without the menus in the corners.
_PLAIN = "<style>.dg, #hunav { display: none !important; }</style></body>"

_SEEK = """<script>
  // The recording arrives after the page; hold it at one time once it is here.
  function hold() {
    const animator = viewer.animator;
    if (animator.duration > 0) {
      animator.pause();
      animator.seek(%r);
      viewer.set_dirty();
      viewer.render();
    }
  }
  for (let k = 1; k <= 4; k++) setTimeout(hold, 1500 * k);
</script></body>"""


def unpacked(html: str) -> str:
    """Returns the page that a replay, the text of its file, unpacks."""
    (packed,) = re.findall(r'id="packed">([A-Za-z0-9+/=]+)<', html)
    return gzip.decompress(base64.b64decode(packed)).decode()


def _run(command: list[str]) -> "subprocess.CompletedProcess[str]":
    """Runs Chromium, which seldom hangs as it starts: then once more."""
    options: dict[str, Any] = {"capture_output": True, "text": True}
    try:
        return subprocess.run(command, **options, timeout=180, check=False)
    except subprocess.TimeoutExpired:
        return subprocess.run(command, **options, timeout=600, check=False)


def render(
    html: Path,
    png: Path,
    time: float | None = None,
    size: tuple[int, int] = (1200, 800),
    view: str = "overview",
) -> Path:
    """Renders a page with headless Chromium; skips the test without one.

    Args:
        html: The page.
        png: The picture to write.
        time: For a recording, the time in it to show, in seconds. By default
            it plays.
        size: The width and height of the picture, in pixels.
        view: The view of a replay, as in its links.

    Returns:
        The path of the picture.
    """
    if CHROMIUM is None:
        pytest.skip("no chromium on the path to look at the page with")
    png = Path(png).resolve()
    png.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        text = Path(html).read_text()
        if 'id="packed"' in text:
            text = unpacked(text)
        text = text.replace("</body>", _PLAIN)
        if time is not None:
            text = text.replace("</body>", _SEEK % float(time))
        page.write_text(text)
        result = _run(
            [
                CHROMIUM,
                "--headless=new",
                "--no-sandbox",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
                f"--user-data-dir={folder}/profile",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                "--ignore-gpu-blocklist",
                "--hide-scrollbars",
                f"--window-size={size[0]},{size[1]}",
                "--virtual-time-budget=8000",
                f"--screenshot={png}",
                f"{page.as_uri()}#view={view}",
            ]
        )
    if not png.exists():
        raise RuntimeError(f"chromium gave no picture:\n{result.stderr}")
    return png
