"""Plots of one or more trials.

Every function gets data and the axes to draw on, `ax`, and returns the axes.
Without `ax` it creates a figure with the width of a column of a paper. It does
not show the figure: notebooks do, and scripts call `matplotlib.pyplot.show` or
`savefig`.

The colors are those of Okabe & Ito 2008, which color-blind people can
distinguish.
"""

import lazy_loader

# The names in the stub file are loaded on first access.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
