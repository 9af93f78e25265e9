"""What keeps the bodies of people and robots apart."""
