"""The parameter that all who look at raw pixels have."""

from blob_tracker.ros.interface import Parameter

SATURATION = Parameter(
    'saturation',
    0,
    'Level at which a pixel is clipped; 0 is full scale of the encoding. Set 4095 for 12 bits in '
    '16.',
    least=0,
    most=65535,
    unit='DN',
)
