"""The fixed world: shapes, obstacles, ray casts, routes."""
