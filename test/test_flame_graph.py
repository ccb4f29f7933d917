"""The picture of where the time goes: boxes as wide as what they stand for, on one scale."""

import re
from xml.etree import ElementTree

from flame_graph import drawn, LEFT, WIDTH
import pytest


def test_boxes_are_as_wide_as_the_time_they_stand_for() -> None:
    """The slower one fills the width; callers are above what they call, from the same place."""
    svg = drawn({
        'Before & after': {'segment': 100.0, 'segment;a.b': 60.0, 'segment;a.b;c.<d>': 40.0},
        'Now': {'segment;a.b': 50.0, 'segment;e.f': 50.0, 'segment;g.h': 0.01},
    })
    ElementTree.fromstring(svg)  # well-formed
    boxes = [
        (name, float(us), float(x), float(y), float(width))
        for name, us, x, y, width in re.findall(
            r'<title>(.*?): ([\d.]+) us</title><rect x="([\d.]+)" y="(\d+)" width="([\d.]+)"', svg
        )
    ]
    scale = (WIDTH - 2 * LEFT) / 200.0
    assert all(width == pytest.approx(us * scale, abs=0.2) for _, us, _, _, width in boxes)
    names = [name for name, *_ in boxes]
    assert names == ['segment', 'a.b', 'c.&lt;d&gt;', 'segment', 'a.b', 'e.f']  # g.h is too small
    (_, outer_us, x, y, _), (_, us, inner_x, below, _) = boxes[:2]
    assert (outer_us, us) == (200.0, 100.0) and inner_x == x and below > y
