#!/usr/bin/env bash
# A compiled function takes FITS pixels in the wrong byte order if it had others before.
#
# Expected: Numba compiles for the types of the arguments. Frames of a FITS file are big-endian
# (>f8), for which it has no type, so that a call with them raises an error, as it does if they are
# the argument itself.
# Happens: in a named tuple they are refused only until the function has been called with native
# ones. After that the tuple counts as the same type, and its bytes are read in the wrong order.
# Matters: the first frame of a test is made by NumPy, those of the telescope come from the file:
# sums of 1e-319 and no error. Convert at the door: frame.astype(float).
#
# Numba 0.61.2 and astropy 7.0.1:
#   an array: NumbaValueError
#   in a named tuple, first call: NumbaValueError
#   a native one: 10
#   in a named tuple after it: 3.352e-319
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 numba==0.61.2 astropy==7.0.1
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
from typing import NamedTuple

from astropy.io import fits
import numba
import numpy as np


class Exposure(NamedTuple):
    """A frame and its gain."""

    frame: np.ndarray
    gain: float


def called(function: object, *arguments: object) -> str:
    """Return what a call gives, or the error's name."""
    try:
        return f'{function(*arguments):.4g}'
    except numba.core.errors.NumbaError as error:
        return type(error).__name__


native = np.arange(1.0, 5.0).reshape(2, 2)
fits.PrimaryHDU(native).writeto('frame.fits')
stored = fits.getdata('frame.fits')
plain = numba.njit(lambda frame: frame.sum())
of_tuple = numba.njit(lambda exposure: exposure.gain * exposure.frame.sum())
plain(native)
results = [
    called(plain, stored),
    called(of_tuple, Exposure(stored, 1.0)),
    called(of_tuple, Exposure(native, 1.0)),
    called(of_tuple, Exposure(stored, 1.0)),
]
for what, result in zip(
    ('an array', 'in a named tuple, first call', 'a native one', 'in a named tuple after it'),
    results,
):
    print(f'{what}: {result}')
if results[:3] != ['NumbaValueError', 'NumbaValueError', '10'] or float(results[3]) > 1e-300:
    raise SystemExit('The byte order of an array in a named tuple is told by now.')
END
