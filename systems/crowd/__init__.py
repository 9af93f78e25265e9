"""People who walk, by one of several models of human motion.

Kernels of n people and m robots have these arguments, unless they say more:

- `states`, `before`, `after`: shape (n, 6), rows (x, y, yaw, vx, vy, omega) in
  W; before a step, and those proposed for its end
- `command`: shape (n, COMMAND_SIZE), see `layout.Command`
- `robots`: shape (m, 7), rows of `robot_states`
- `radii`, `bodies`: shape (n,), of people and of their bodies, in meters
- `parameters`: shape (n, 13), the fields of SocialForceParameters
- `at_walls`: shape (n, 2), see `Snapshot`
- `forces`: shape (n, FORCES_SIZE), see `layout.FORCES`, in m/s^2
- `stances`: shape (n, 3), see `bodies.standing`
- `table`, `walls`: `Obstacles.table`, and its parts as `Walls`
- `reach`, `most`: walls farther than this, in meters, exert no force, and no
  more than so many of the nearest do; 0 for all within reach
- `time_step`, `step`: the time step, in seconds
"""

import lazy_loader

# The names in the stub beside this file are loaded on first use.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
