"""The command `hunav doctor`."""

import argparse
import dataclasses
import json
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, FAILED

if TYPE_CHECKING:
    from hunav_drake.commands.doctor_findings import Finding


def add_doctor_options(doctor: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav doctor`."""
    doctor.set_defaults(function=_doctor)
    doctor.add_argument(
        "--json", action="store_true", help="print the findings as JSON"
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
            f"\n{troubles} to fix: see the lines with 'trouble'"
            if troubles
            else "\nNothing is missing."
        )
    return FAILED if troubles else DONE


def _line(finding: "Finding") -> str:
    remedy = f"; {finding.remedy}" if finding.remedy else ""
    return f"{finding.state:8} {finding.name:14} {finding.text}{remedy}"
