"""The modules that all building blocks share."""
