"""ROS 2 without ROS: its messages, DDS, and a planner beyond it."""

import lazy_loader

# What the stub beside this file lists is loaded when it is first asked for.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
