"""A camera that averages its frames over time."""

import numpy as np
import pytest
from support.flashes import circle, fly


@pytest.mark.parametrize('kept, speed', [(0.2, 1.0), (0.3, 1.0), (0.4, 0.3)])
def test_the_last_flash_is_noticed_and_named(kept, speed):
    """Place a moving light that its own past would pull 0.2 to 0.3 px ahead."""
    flight = fly(circle(260, speed), lambda k, rows: np.full(rows.shape, float(k % 2 == 0)),
                 kept=kept)
    # 110 places: 0.57 are three standard errors; the noise of both windows is correlated.
    assert 1.4 < flight.nees < 2.8
    assert flight.said('averages over time') > 0.9
