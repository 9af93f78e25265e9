"""The command `hunav doctor`."""

import argparse
import dataclasses
import json
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import DONE, FAILED

if TYPE_CHECKING:
    from hunav_drake.commands.doctor_findings import Finding


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
    from hunav_drake.commands.doctor_findings import find_all

    found = []
    for finding in find_all():
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


def _line(finding: "Finding") -> str:
    remedy = f"; {finding.remedy}" if finding.remedy else ""
    return f"{finding.state:8} {finding.name:14} {finding.text}{remedy}"
