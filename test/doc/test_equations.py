"""Equations of docstrings as LaTeX; what is no equation is left as it stands."""

from __future__ import annotations

from equations import latex, typeset
import pytest


@pytest.mark.parametrize(
    'line, expected',
    [
        ('I_pq = sum_k (d mu_k / d p) / V_k', r'I_{pq} = \sum_{k} (d \mu _{k} / d p) / V_{k}'),
        ('s^2 (J^T J)^-1', 's^{2} (J^{T} J)^{-1}'),
        ('sqrt(pi / 2) sigma / a', r'\sqrt{\pi  / 2} \sigma  / a'),
        ('m / gain + read_noise^2    DN^2',
         r'm / \mathrm{gain} + \mathrm{read\_noise}^{2} \qquad \mathrm{DN}^{2}'),
        ('azimuth = atan2(X, Z)', r'\mathrm{azimuth} = \operatorname{atan2}(X, Z)'),
        ('r = theta (1 + k1 theta^2)', r'r = \theta  (1 + k_{1} \theta ^{2})'),
        ('exp(-(r / s)^2) <= 1', r'\exp (-(r / s)^{2}) \le  1'),
        ('x over y', r'x \ \text{over}\  y'),
    ],
)
def test_a_line(line: str, expected: str) -> None:
    """Letters, Greek ones, functions, words, and what is raised and lowered."""
    assert latex(line) == expected


def test_blocks_that_are_set_off() -> None:
    """An equation becomes mathematics, a command a literal block; all else stays."""
    found = typeset([
        'The variance is', '', '    v = m / gain,', '    m = a + b', '', 'DN^2, of |m|:', '',
        '    python tools/reference.py', '', 'Parameters', '----------', 'x : float', r'    DN\.',
        '', '    More of it.',
    ])
    assert found == [
        'The variance is', '', '.. math::', '', r'   \begin{aligned}',
        r'   & v = m / \mathrm{gain}, \\', r'   & m = a + b \\', r'   \end{aligned}', '',
        r'DN^2, of \|m\|:', '', '::', '', '    python tools/reference.py', '', 'Parameters',
        '----------', 'x : float', r'    DN\.', '', '    More of it.',
    ]


def test_a_unit_alone_is_no_list() -> None:
    """`mm.` would be a Roman number, `s.` a letter."""
    assert typeset(['f : float', '    mm.', '    Of s. it says']) == [
        'f : float', r'    mm\.', '    Of s. it says',
    ]


def test_a_literal_block_stays() -> None:
    """One that is marked as such, also with an equals sign in it."""
    lines = ['As in', '', '::', '', '    x = 1']
    assert typeset(lines) == lines
