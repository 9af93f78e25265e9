"""Comparisons of the planners of a suite: means, tables and relations."""
