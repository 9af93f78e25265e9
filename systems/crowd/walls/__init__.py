"""How walls lead people, and keep them out."""
