"""The fixed world: shapes, obstacles, ray casts, routes."""

import lazy_loader

# The names in the stub beside this file are loaded on first use.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
