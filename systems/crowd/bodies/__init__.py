"""Keeps the bodies of people and robots apart."""
