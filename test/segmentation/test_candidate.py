"""What a candidate tells of itself."""

from support.contrasts import candidate_at


def test_peak_is_a_pixel() -> None:
    """Whole numbers, column first, though the table of candidates holds none."""
    peak = candidate_at(41, 17, x=43.2, y=15.9).peak
    assert peak == (41, 17)
    assert all(type(each) is int for each in peak)
