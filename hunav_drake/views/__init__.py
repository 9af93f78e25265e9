"""What one sees of trials: replays with controls, live views, and films."""
