"""Scenes in which a planner fails, and how likely a failure is."""
