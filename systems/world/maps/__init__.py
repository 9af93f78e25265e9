"""Maps of cells, as robots make them, and the walls in them."""
