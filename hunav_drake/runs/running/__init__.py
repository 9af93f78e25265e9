"""How the runs of a suite are given out, done and kept."""
