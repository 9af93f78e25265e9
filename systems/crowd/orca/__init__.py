"""Optimal reciprocal collision avoidance (ORCA)."""
