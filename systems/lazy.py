"""Packages that load what they export when it is first asked for.

So a scenario can be checked without Drake's geometry, and a command can
answer without numba.
"""

from collections.abc import Callable, Mapping
import importlib
import sys
from typing import Any


def lazy_exports(
    package: str, modules: Mapping[str, str]
) -> Callable[[str], Any]:
    """Returns the `__getattr__` of a package that exports lazily.

    What it exports is listed by `dir`, too, as completion needs it.

    Args:
        package: The name of the package.
        modules: The module that each exported name lives in.
    """
    exporter: Any = sys.modules[package]
    exporter.__dir__ = lambda: sorted({*vars(exporter), *modules})

    def load(name: str) -> Any:
        if name not in modules:
            raise AttributeError(
                f"module {package!r} has no attribute {name!r}"
            )
        value = getattr(importlib.import_module(modules[name]), name)
        setattr(exporter, name, value)
        return value

    return load
