"""Validation cases: how realistic the motion models are."""
