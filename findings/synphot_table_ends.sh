#!/usr/bin/env bash
# synphot goes on beyond the end of a table with its last value, if a filter comes after it.
#
# Expected: a quantum efficiency given from 400 to 700 nm says nothing at 850 nm: an observation
# there is refused, as it is when the table stands alone (DisjointError).
# Happens: a table that does not end in zeros is taken to hold its end values for ever. Multiplied
# by a filter for 850 nm, the product lies where the source is, and counts come.
# Matters: a budget for an infrared light and a sensor whose curve was read off to the visible only
# sees it with the efficiency of its last point. Give each table a zero at both ends.
#
# synphot 1.8.0, an LED at 850 nm, efficiency 0.3 at 700 nm where its table ends:
#   the table: DisjointError
#   the table and a filter: 0.30 of all photons
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.15.3 astropy==7.1.0 synphot==1.8.0
"$folder/venv/bin/python" -I - <<'END'
from astropy import units
import numpy as np
from synphot import Observation, SourceSpectrum, SpectralElement
from synphot.exceptions import DisjointError
from synphot.models import Box1D, Empirical1D, GaussianFlux1D

AREA = 1 * units.cm ** 2
BINS = np.arange(3000.0, 12_000.0, 10.0)  # Angstrom

light = SourceSpectrum(
    GaussianFlux1D, mean=8500, fwhm=300, total_flux=1e-12 * units.erg / units.s / units.cm ** 2)
efficiency = SpectralElement(
    Empirical1D, points=[4000, 5000, 6000, 7000], lookup_table=[0.5, 0.7, 0.6, 0.3])
window = SpectralElement(Box1D, amplitude=1, x_0=8500, width=800)


def counts(response: SpectralElement) -> float:
    """Return what is counted in a second."""
    return Observation(light, response, binset=BINS).countrate(area=AREA).value


try:
    counts(efficiency)
    alone = 'counts'
except DisjointError:
    alone = 'DisjointError'
share = counts(efficiency * window) / counts(window)
print(f'the table: {alone}')
print(f'the table and a filter: {share:.2f} of all photons')

if not (alone == 'DisjointError' and abs(share - 0.3) < 0.01):
    raise SystemExit('A table ends where it ends by now.')
END
