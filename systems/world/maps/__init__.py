"""Maps of cells: occupancy maps, the walls in them, and costmaps."""
