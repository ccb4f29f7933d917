"""The parameter that all who make raw pixels linear have."""

from blob_tracker.ros.interface import Parameter

RESPONSE = Parameter(
    'response_url',
    '',
    'Response of a camera with a gamma curve, as `calibrate response` writes it: path, file:// or '
    'package://. The segmenter makes the pixels linear with it and the locator must know it: give '
    'both the same. noise.* is then that of linear pixels, saturation in raw DN. Empty for a '
    'linear camera.',
)
