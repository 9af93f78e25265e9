"""Trials as ROS 2 topics: bags, a live bridge, and Foxglove."""
