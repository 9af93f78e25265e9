"""Packages that load what they export when it is first asked for.

So a scenario can be checked without Drake's geometry, and a command can
answer without numba.
"""

from collections.abc import Callable, Mapping
import importlib
from typing import Any


def lazy_exports(
    package: str, modules: Mapping[str, str]
) -> Callable[[str], Any]:
    """Returns the `__getattr__` of a package that exports lazily.

    Args:
        package: The name of the package.
        modules: The module that each exported name lives in.
    """

    def load(name: str) -> Any:
        if name not in modules:
            raise AttributeError(
                f"module {package!r} has no attribute {name!r}"
            )
        return getattr(importlib.import_module(modules[name]), name)

    return load
