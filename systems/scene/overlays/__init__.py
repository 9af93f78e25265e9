"""What Meshcat shows besides figures, floor and walls."""
