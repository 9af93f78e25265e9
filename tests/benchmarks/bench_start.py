"""How long short commands take, in CPU time of their own processes."""

import os
from pathlib import Path
import resource
import subprocess
import sys
import tempfile
import timeit

# The commands, "" for the folder of results.
COMMANDS = (
    ("--help",),
    ("check", "passing"),
    ("run", "passing"),
    ("run", "passing", "--out", ""),
    ("who", "crossing", "--at", "4", "--until", "12"),
    ("branch", "crossing", "--at", "4", "--until", "12", "--robot", "gone"),
)


def cpu_seconds(words: tuple[str, ...], folder: Path) -> float:
    """Returns the CPU time of a command, user and system, in seconds."""
    arguments = [word or str(folder / os.urandom(4).hex()) for word in words]
    code = "from hunav_drake.commands.cli import main; raise SystemExit(main())"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-c", code, *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Prints the least time of five calls, and that of a plain loop."""
    loop = "for _ in range(20_000_000): pass"
    plain = min(timeit.repeat(loop, number=1, repeat=3))
    print(f"A plain loop of 20 million turns: {plain:.2f} s")
    print("CPU s  in loops  command")
    with tempfile.TemporaryDirectory() as folder:
        for words in COMMANDS:
            least = min(cpu_seconds(words, Path(folder)) for _ in range(5))
            told = " ".join(word or "DIR" for word in words)
            print(f"{least:5.2f}  {least / plain:8.1f}  hunav {told}")


if __name__ == "__main__":
    main()
