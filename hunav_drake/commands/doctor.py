"""The command `hunav doctor`."""

import argparse
import time
from typing import Any

from hunav_drake.commands.errors import DONE, FAILED


def add_doctor_command(commands: Any) -> None:
    """Adds the command `hunav doctor`."""
    doctor = commands.add_parser(
        "doctor", help="show the versions in use, and run a short test"
    )
    doctor.set_defaults(function=_doctor)


def _doctor(options: argparse.Namespace) -> int:
    from hunav_drake.results.provenance import MakeProvenance
    from hunav_drake.scenario import LoadScenario, SaveScenario
    from hunav_drake.simulation import RunTrial
    from hunav_drake.systems.common.registry import name_of

    scenario = LoadScenario(
        filename="passing", overrides=["simulation.duration=2.0"]
    )
    provenance = MakeProvenance(
        SaveScenario(scenario), seed=0, planner=name_of(scenario.planner)
    )
    for key, value in provenance.items():
        print(f"{key:18} {value}")
    started = time.perf_counter()
    first = RunTrial(scenario)
    elapsed = time.perf_counter() - started
    repeats = first.recording == RunTrial(scenario).recording
    print(f"{'short run':18} ok, {elapsed:.2f} s for {first.end_time:g} s")
    print(f"{'repeats':18} {'ok, bit for bit' if repeats else 'NO'}")
    return DONE if repeats else FAILED
