"""The social force model."""
