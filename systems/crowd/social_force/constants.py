"""Thresholds that all forms of the social force model share.

Plain numbers, which numba takes for constants.
"""

# Angles smaller than this are rounding noise of an exact head-on encounter.
THETA_ZERO = 1e-12

# A vector shorter than this, in its own unit, has no derivative: that of its
# direction would overflow.
SHORT = 1e-100

# The exponents of exp. With derivatives, below the first it gives 0, in spite
# of others that overflow; above the second, deep in a body with a hard
# surface, no push grows: no force is infinite.
LEAST, MOST = 800.0, 300.0

# The distance to a robot's center below which its extra push does not grow, in
# meters.
REPULSION_FLOOR = 0.05

# A person slower than this keeps the yaw, in m/s.
YAW_SPEED = 1e-6
