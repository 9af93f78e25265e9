"""The edited document: plain data, the same as text, and the history."""
