#!/usr/bin/env bash
# Skyfield corrects no refraction if it is told the pressure but not the temperature.
#
# Expected: altaz(pressure_mbar=1013), the pressure of the air at the camera, is the altitude at
# which a satellite or a star is seen; without a temperature the standard one is taken.
# Happens: the temperature alone switches refraction on. Without it the pressure is not looked at,
# and the altitude is that without air.
# Matters: a camera aimed at, or calibrated on, low stars or satellites is off by 0.1 degrees at
# 8 degrees and 0.5 at the horizon. Pass temperature_C='standard' as well.
#
# skyfield 1.55, the altitude of a satellite (degrees):
#   without air: 7.7254
#   pressure_mbar=1013: 7.7254
#   temperature_C='standard': 7.8365
#   both: 7.8381
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 sgp4==2.27 jplephem==2.24 skyfield==1.55
"$folder/venv/bin/python" -I - <<'END'
from skyfield.api import EarthSatellite, load, wgs84

ELEMENTS = (
    '1 25544U 98067A   14020.93268519  .00009878  00000-0  18200-3 0  5082',
    '2 25544  51.6498 109.4756 0003572  55.9686 274.8005 15.49815350868473',
)

times = load.timescale(builtin=True)
camera = wgs84.latlon(40.8939, -83.8917, elevation_m=100)
seen = (EarthSatellite(*ELEMENTS, ts=times) - camera).at(times.utc(2014, 1, 21, 0, 384))

found = []
for name, air in (('without air', {}),
                  ('pressure_mbar=1013', {'pressure_mbar': 1013}),
                  ("temperature_C='standard'", {'temperature_C': 'standard'}),
                  ('both', {'temperature_C': 'standard', 'pressure_mbar': 1013})):
    found.append(seen.altaz(**air)[0].degrees)
    print(f'{name}: {found[-1]:.4f}')

vacuum, pressure, temperature, both = found
if not (pressure == vacuum and 0.1 < temperature - vacuum < 0.12 and 0.1 < both - vacuum < 0.12):
    raise SystemExit('Skyfield refracts with the pressure alone by now.')
END
