"""The nodes of behavior trees, and the register of their types."""
