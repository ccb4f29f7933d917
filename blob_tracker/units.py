"""
The milliradian of the bearings and the radian of all else.

Both ways are there because `x * MRAD_PER_RAD` and `x / MRAD` differ by a rounding, and results are
compared bit by bit.
"""

MRAD = 1e-3  # rad
MRAD_PER_RAD = 1e3
