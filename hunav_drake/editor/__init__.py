"""The editor of scenarios: a page, or a widget, on one session."""
