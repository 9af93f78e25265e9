"""Models of files (URDF, SDF, model directives) that Drake reads."""
