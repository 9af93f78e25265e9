"""Recorded people from files of many formats."""
