#!/usr/bin/env bash
# trackpy loses a light because the picture has no noise.
#
# Expected: what is found in a noisy frame is found in the same frame without noise.
# Happens: a feature has to be brighter than a percentile (64) of those pixels that are not black
# after the bandpass. With noise these are pixels of the background, without it those of the
# lights alone: of two of the same size the fainter is below the percentile from about 1:7 on.
# Matters: frames from which the dark was taken and clipped, or simulated ones, lose lights
# that the eye sees at once. minmass does not help, percentile=0 does.
#
# trackpy 0.7, lights of 240 and 24 DN, diameter 7 px, is the fainter one found?
#   with noise: True
#   without: False
#   without, percentile=0: True
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.3.5 scipy==1.16.3 pandas==2.3.3 looseversion==1.3.0 pyyaml==6.0.3
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps trackpy==0.7
"$folder/venv/bin/python" -I -W ignore - <<'END'
import numpy as np
import trackpy

trackpy.quiet()
y, x = np.mgrid[:128, :160]


def light(column: float, row: float, peak: float) -> np.ndarray:
    """Return the picture of a light, DN."""
    return peak * np.exp(-((x - column) ** 2 + (y - row) ** 2) / (2 * 1.5 ** 2))


def found(picture: np.ndarray, **options: float) -> bool:
    """Tell whether the fainter light is among the features."""
    features = trackpy.locate(picture, 7, **options)
    return bool((np.hypot(features.x - 100.2, features.y - 85.7) < 1).any())


clean = light(40.3, 30.4, 240) + light(100.2, 85.7, 24)
noisy = clean + 10 + np.random.default_rng(0).normal(0, 1, clean.shape)
clean, noisy = (np.clip(each.round(), 0, 255).astype(np.uint8) for each in (clean, noisy))
told = found(noisy), found(clean), found(clean, percentile=0)
print('with noise: {}\nwithout: {}\nwithout, percentile=0: {}'.format(*told))
if told != (True, False, True):
    raise SystemExit('trackpy no longer loses the fainter light of a clean picture.')
END
