#!/usr/bin/env bash
# sep.extract finds other sources with err=3.0 than with a map of the noise that is 3.0 everywhere.
#
# Expected: err may be "float or array", so a number is short for an array of that number.
# Happens: a map switches to a matched filter, whose threshold is meant in sigma of the filtered
# picture; with a number the smoothed picture is held against the sigma of a single pixel. The
# same threshold is then several times higher, and the same error of noise maps as well.
# Matters: a threshold that was tuned one way is far off the other: lights are lost, or the
# noise itself is found.
#
# sep 1.4.1, sources found of 100 of peak 4 sigma, and in noise alone, with a number and a map:
#   3 sigma: 3 and 100; 0 and 0
#   2 sigma: 99 and 106; 0 and 115
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 sep==1.4.1
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
import sep

SIGMA = 3.0  # DN
SIZE, PITCH = 400, 40  # px
random = np.random.default_rng(1)
y, x = np.mgrid[:SIZE, :SIZE] % PITCH - PITCH / 2
noise = random.normal(0, SIGMA, (SIZE, SIZE))
lights = noise + 4 * SIGMA * np.exp(-(x ** 2 + y ** 2) / (2 * 1.5 ** 2))
noise_map = np.full((SIZE, SIZE), SIGMA)

found = {}
for threshold in (3.0, 2.0):
    counts = [len(sep.extract(picture, threshold, err=err))
              for picture in (lights, random.normal(0, SIGMA, (SIZE, SIZE)))
              for err in (SIGMA, noise_map)]
    print('{:.0f} sigma: {} and {}; {} and {}'.format(threshold, *counts))
    found[threshold] = counts

if not (found[3.0][0] < 20 and found[3.0][1] > 95 and found[2.0][2] < 5 < 50 < found[2.0][3]):
    raise SystemExit('sep.extract no longer takes a number and a map of the noise differently.')
END
