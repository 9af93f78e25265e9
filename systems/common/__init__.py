"""What all building blocks share."""
