"""How an optical frame stands in a body frame with x forward, y left and z up (REP 103)."""

# Fixed-axis angles as static_transform_publisher has them, rad: quarter turns, in ten digits.
ROLL, PITCH, YAW = -1.5707963268, 0.0, -1.5707963268
