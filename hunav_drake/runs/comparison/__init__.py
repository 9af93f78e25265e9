"""How the planners of a suite compare: means, tables and relations."""
