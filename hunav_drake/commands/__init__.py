"""The commands of `hunav`."""
