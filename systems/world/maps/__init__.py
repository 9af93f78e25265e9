"""Maps of cells: those that robots make, with the walls in them, and costs."""
