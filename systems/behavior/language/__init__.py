"""The language of behavior trees: reading and writing XML."""
