"""Runs all benchmarks: `make bench`."""

import importlib
from pathlib import Path

for path in sorted(Path(__file__).parent.glob("bench_*.py")):
    print(f"== {path.stem}", flush=True)
    importlib.import_module(f"tests.benchmarks.{path.stem}").main()
    print()
