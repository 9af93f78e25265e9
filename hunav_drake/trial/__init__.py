"""A trial: its diagram, simulator, seed, result and saved Contexts."""
