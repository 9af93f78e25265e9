"""Many runs: suites, result folders, recordings, tables and statistics."""

import lazy_loader

# The names in the stub file are loaded on first access.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
