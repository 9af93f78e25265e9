"""The command `hunav doctor`."""

import argparse
from collections.abc import Iterator
import dataclasses
import json
import time
from typing import Any

from hunav_drake.commands.doctor_findings import Finding, examine
from hunav_drake.commands.errors import DONE, FAILED


def add_doctor_command(commands: Any) -> None:
    """Adds the command `hunav doctor`."""
    doctor = commands.add_parser(
        "doctor",
        help="find what is missing on this machine, and run a short test",
    )
    doctor.set_defaults(function=_doctor)
    doctor.add_argument(
        "--json", action="store_true", help="print what is found as JSON"
    )


def _doctor(options: argparse.Namespace) -> int:
    found = []
    for finding in _all_findings():
        found.append(finding)
        if not options.json:
            print(_line(finding), flush=True)
    troubles = sum(finding.state == "trouble" for finding in found)
    if options.json:
        findings = [dataclasses.asdict(finding) for finding in found]
        print(json.dumps({"ok": not troubles, "findings": findings}, indent=2))
    else:
        print(
            f"\n{troubles} to mend: see the lines with 'trouble'"
            if troubles
            else "\nAll that is needed is there."
        )
    return FAILED if troubles else DONE


def _all_findings() -> Iterator[Finding]:
    """Yields what is found; runs trials only if nothing is in the way."""
    troubles = 0
    for finding in examine():
        troubles += finding.state == "trouble"
        yield finding
    if not troubles:
        yield from _short_runs()


def _short_runs() -> Iterator[Finding]:
    """Runs a short trial twice, which must give the same."""
    from hunav_drake.scenario import LoadScenario
    from hunav_drake.trial.compiling import told_compile_time
    from hunav_drake.trial.simulation import RunTrial

    scenario = LoadScenario(
        filename="passing", overrides=["simulation.duration=2.0"]
    )
    started = time.perf_counter()
    with told_compile_time() as compiled:
        first = RunTrial(scenario)
    elapsed = time.perf_counter() - started - compiled.seconds
    yield Finding(
        "short run", "ok", f"{elapsed:.2f} s for {first.end_time:g} s"
    )
    if first.recording == RunTrial(scenario).recording:
        yield Finding("repeats", "ok", "bit for bit")
    else:
        yield Finding(
            "repeats",
            "trouble",
            "two equal runs differ",
            "report it, with the output of `hunav doctor --json`",
        )


def _line(finding: Finding) -> str:
    remedy = f"; {finding.remedy}" if finding.remedy else ""
    return f"{finding.state:8} {finding.name:14} {finding.text}{remedy}"
