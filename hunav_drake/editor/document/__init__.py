"""What is edited: plain data and their text, in step, with all steps back."""
