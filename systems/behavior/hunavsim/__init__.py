"""The behaviors of HuNavSim as they are there: leaves and trees."""
