"""What `hunav edit` needs until there is a page."""

import os
from pathlib import Path
import re
import subprocess
import sys
import urllib.request

import pytest

pytest.importorskip("tornado", reason="the extra `editor` is not here")


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/maps").exists(), reason="there is no /proc"
)
def test_a_page_comes_soon_from_a_small_process():
    code = "from hunav_drake.commands.cli import main; main()"
    command = [sys.executable, "-c", code, "edit", "cafe", "--no-browser"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            process.stdout.readline()
            url = process.stdout.readline().strip()
            with urllib.request.build_opener(
                urllib.request.HTTPCookieProcessor()
            ).open(url) as page:
                assert b"<script" in page.read()
            proc = Path(f"/proc/{process.pid}")
            stat = (proc / "stat").read_text().rpartition(")")[2].split()
            ticks = int(stat[11]) + int(stat[12])
            seconds = ticks / os.sysconf("SC_CLK_TCK")
            maps = (proc / "maps").read_text()
            status = (proc / "status").read_text()
        finally:
            process.kill()
    memory = int(re.search(r"VmRSS:\s*(\d+) kB", status)[1]) / 1024
    print(f"{seconds:.2f} s of CPU until the page, {memory:.0f} MB")
    assert not [it for it in ("pydrake", "llvmlite") if it in maps]
    assert seconds < 3.0
    assert memory < 100
