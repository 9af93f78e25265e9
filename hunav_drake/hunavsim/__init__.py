"""All that knows HuNavSim: its files, services and differences."""
