"""Views of trials: replays with controls, live views, and films."""
