"""Scenarios: loading, checking and saving trials."""

import lazy_loader

# The names in the stub beside this file are loaded at their first use.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
