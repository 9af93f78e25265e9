"""HuNavSim's files and services, and the differences from it."""
