"""The guidance of people by walls, and their contact with walls."""
