"""The editor of scenarios: in the browser, and in notebooks."""
