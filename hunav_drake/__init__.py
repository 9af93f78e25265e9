"""Simulated people for Drake: a trial of social navigation as one Diagram."""

import lazy_loader

# HuNavSim's formats are known to whoever reads a file.
from hunav_drake.hunavsim import formats as _formats  # noqa: F401

# What the stub beside this file lists is loaded when it is first asked for.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
