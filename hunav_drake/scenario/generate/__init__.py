"""Scenarios drawn from a seed: fields of columns, corridors, rooms, offices."""
