"""Samples that have a byte or a word each."""

import numpy as np
import pytest


@pytest.mark.parametrize(('name', 'bits', 'layout', 'shift', 'dtype'), [
    ('GREY', 8, 'u1', 0, np.uint8),
    ('Y10', 10, '<u2', 0, np.uint16),
    ('Y12', 12, '<u2', 0, np.uint16),
    ('Y012', 12, '<u2', 4, np.uint16),
    ('Y14', 14, '<u2', 0, np.uint16),
    ('Y16', 16, '<u2', 0, np.uint16),
    ('Y16-BE', 16, '>u2', 0, np.uint16),
])
def test_samples(decode, name, bits, layout, shift, dtype):
    samples = np.random.default_rng(1).integers(0, 1 << bits, (5, 7), np.uint16)
    decoded = decode(name, (samples << shift).astype(layout), 7, 5)
    assert decoded.dtype == dtype
    np.testing.assert_array_equal(decoded, samples)


def test_byte_order(decode):
    lines = np.array([[0x12, 0x34]], np.uint8)
    assert decode('Y16', lines, 1, 1) == 0x3412
    assert decode('Y16-BE', lines, 1, 1) == 0x1234
