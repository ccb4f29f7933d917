#!/usr/bin/env bash
# LombScargle finds a light that flashes 5 times a second at 65 Hz in 30 frames a second.
#
# Expected: autopower looks at frequencies up to 15 Hz, that of Nyquist, or at least finds the true
# one to be the highest of all.
# Happens: it looks up to five times that of Nyquist, as uneven samples allow. Evenly sampled, each
# frequency has four equals there, and the rounding of the grid decides which one is the highest.
# Matters: a light is told by a frequency that no camera of that rate can tell, and with jitter of
# the stamps by another one each time. Pass maximum_frequency.
#
# astropy 7.1.0, highest peak for 40 phases of a light (Hz):
#   as it is: 65.0
#   maximum_frequency=15: 5.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.15.3 astropy==7.1.0
"$folder/venv/bin/python" -I - <<'END'
from astropy.timeseries import LombScargle
import numpy as np

FLASHES, RATE = 5.0, 30.0  # Hz
random = np.random.default_rng(1)
times = np.arange(300) / RATE


def peaks(**settings: float) -> np.ndarray:
    """Return the frequencies that are found for a light that is on half of the time."""
    highest = []
    for phase in random.uniform(size=40):
        light = 100.0 * ((FLASHES * times + phase) % 1 < 0.5) + random.normal(0, 3, len(times))
        frequency, power = LombScargle(times, light).autopower(**settings)
        highest.append(frequency[power.argmax()])
    return np.unique(np.round(highest, 1))


found, limited = peaks(), peaks(maximum_frequency=RATE / 2)
print('as it is:', *found)
print('maximum_frequency=15:', *limited)

if not (found.max() > RATE / 2 and limited.tolist() == [FLASHES]):
    raise SystemExit('autopower stays below the frequency of Nyquist by now.')
END
