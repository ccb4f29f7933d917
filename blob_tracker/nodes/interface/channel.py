"""The colour of the light, a parameter of camera and segmenter alike."""

from blob_tracker.colour import AUTO, CHANNELS
from blob_tracker.ros.interface import Parameter

_CHOICES = (AUTO, *CHANNELS)
CAMERA_CHANNEL = Parameter(
    'channel',
    AUTO,
    'Colour of the light, for find_exposure. The frames have all colours that the pixel format '
    'has for each pixel (Bayer as it comes, RGB), for the segmenter to choose from; luma makes '
    'them grey, a Bayer mosaic half as large from its green samples.',
    choices=_CHOICES,
)
SEGMENTER_CHANNEL = Parameter(
    'channel',
    AUTO,
    'Colour in which the light is looked for, of a colour camera. auto: the one in which it '
    'flashes strongest; name the colour of a light that does not flash. Luma of a Bayer mosaic is '
    'green.',
    choices=_CHOICES,
)
