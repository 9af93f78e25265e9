"""Branches of a trial: what would be, from one instant on."""
