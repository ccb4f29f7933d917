"""Samples without gaps between them, against their bits written out one by one."""

import numpy as np
import pytest


def mipi(samples, bits, count):
    """Pack samples as CSI-2 does: upper bytes, then the low bits, the first sample's lowest."""
    extra = bits - 8
    packed = []
    for group in np.reshape(samples, (-1, count)):
        packed += [int(sample) >> extra for sample in group]
        low = ''.join(f'{int(sample) % (1 << extra):0{extra}b}' for sample in group[::-1])
        packed += int(low, 2).to_bytes(count * extra // 8, 'little')
    return np.array(packed, np.uint8)


def string_of_bits(samples):
    """Pack samples of 10 bits one after the other, the most significant bit first."""
    bits = ''.join(f'{int(sample):010b}' for sample in samples)
    return np.array([int(bits[place:place + 8], 2) for place in range(0, len(bits), 8)], np.uint8)


PACKINGS = [
    ('Y10P', 10, lambda row: mipi(row, 10, 4)),
    ('Y12P', 12, lambda row: mipi(row, 12, 2)),
    ('Y14P', 14, lambda row: mipi(row, 14, 4)),
    ('Y10B', 10, string_of_bits),
]


@pytest.mark.parametrize(('name', 'bits', 'pack'), PACKINGS)
@pytest.mark.parametrize('width', [16, 13])
def test_samples(decode, name, bits, pack, width):
    samples = np.random.default_rng(2).integers(0, 1 << bits, (6, 16))
    decoded = decode(name, np.array([pack(row) for row in samples]), width, 6)
    assert decoded.dtype == np.uint16
    assert decoded.flags.c_contiguous
    # An odd width ends within a group, that is there as a whole.
    np.testing.assert_array_equal(decoded, samples[:, :width])


def test_fourteen_bits_as_the_kernels_table_has_them(decode):
    # Documentation/userspace-api/media/v4l/pixfmt-yuv-luma.rst: Y'0[13:6] .. Y'3[13:6], then from
    # the top Y'1[1:0] Y'0[5:0], Y'2[3:0] Y'1[5:2], Y'3[5:0] Y'2[5:4].
    a, b, c, d = samples = 0x2a7b, 0x1c35, 0x0f6e, 0x3391
    line = [
        a >> 6, b >> 6, c >> 6, d >> 6, (b & 3) << 6 | a & 63, (c & 15) << 4 | b >> 2 & 15,
        (d & 63) << 2 | c >> 4 & 3]
    np.testing.assert_array_equal(decode('Y14P', np.array([line], np.uint8), 4, 1), [samples])


def test_the_kernels_own_example():
    # Documentation/userspace-api/media/v4l/pixfmt-srggb10p.rst: the fifth byte holds, from its
    # top, the low bits of the fourth, third, second and first sample.
    packed = mipi([0b11, 0b10, 0b01, 0b00], 10, 4)
    np.testing.assert_array_equal(packed, [0, 0, 0, 0, 0b00_01_10_11])
