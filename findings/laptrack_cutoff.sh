#!/usr/bin/env bash
# LapTrack joins two lights 14 px apart in neighbouring frames, with a cutoff of 5 px.
#
# Expected: cutoff=25 (squared pixels, as the metric is) is the longest step of a track; gaps are
# closed where a track has a gap.
# Happens: closing gaps takes each end of a track and each start of another up to two frames later,
# the very next frame included, with a cutoff of its own, 15 px unless it is given.
# Matters: a light that goes out as its neighbour goes on becomes one light that jumps. Give
# gap_closing_cutoff as well, or gap_closing_max_frame_count=0.
#
# laptrack 0.17.1, a light of three frames, then another one beside it of three frames:
#   14 px apart: 1 track
#   14 px apart, gap_closing_cutoff=25: 2 tracks
#   16 px apart: 2 tracks
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 pandas==2.3.3 laptrack==0.17.1
"$folder/venv/bin/python" -I - <<'END'
from laptrack import LapTrack
import pandas

CUTOFF = 25.0  # px^2


def tracks(apart: float, **settings: float) -> int:
    """Return how many tracks two lights make, of which the second follows the first."""
    lights = pandas.DataFrame({'frame': range(6), 'x': [0.0] * 3 + [apart] * 3, 'y': 0.0})
    found, _, _ = LapTrack(cutoff=CUTOFF, **settings).predict_dataframe(
        lights, ['x', 'y'], frame_col='frame')
    return found['track_id'].nunique()


near, given, far = tracks(14.0), tracks(14.0, gap_closing_cutoff=CUTOFF), tracks(16.0)
print(f'14 px apart: {near} track')
print(f'14 px apart, gap_closing_cutoff=25: {given} tracks')
print(f'16 px apart: {far} tracks')

if (near, given, far) != (1, 2, 2):
    raise SystemExit('The cutoff holds for neighbouring frames by now.')
END
