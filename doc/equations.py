r"""
Equations of the docstrings as Sphinx typesets them.

In the sources they are plain lines, set off by a blank line and four columns:

    sigma^2 = blur^2 + (D f / 4 R)^2

which becomes `\sigma^{2} = \mathrm{blur}^{2} + (D f / 4 R)^{2}` in a directive for mathematics.
"""

from __future__ import annotations

from collections.abc import Iterator
import re

INDENT = 4  # columns by which a block is set off
GREEK = frozenset((
    'alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau '
    'upsilon phi chi psi omega'
).split())
FUNCTIONS = frozenset('exp ln log sin cos tan det min max'.split())
NAMED = {
    'sqrt2': r'\sqrt{2}', 'sum': r'\sum', 'integral': r'\int', 'prod': r'\prod', 'grad': r'\nabla',
    'infinity': r'\infty', 'Delta': r'\Delta ',
}
SIGNS = {
    '<=': r'\le ', '>=': r'\ge ', '->': r'\to ', '+-': r'\pm ', '-+': r'\mp ', '~': r'\sim ',
    '*': r'\cdot ', '%': r'\%', '#': r'\#', '&': r'\&', '{': r'\{', '}': r'\}', '$': r'\$',
    '²': '^{2}', '³': '^{3}', '⁴': '^{4}', '⁵': '^{5}', 'ᵀ': '^{T}', '⁻': '^{-}', '¹': '^{1}',
    '×': r'\times ', '°': r'^{\circ}', '·': r'\cdot ', '±': r'\pm ', '...': r'\ldots ',
}
WORDS = '|'.join((*GREEK, *FUNCTIONS, *NAMED))
TOKEN = re.compile(
    r'(?P<gap>\s{2,})|(?P<space>\s)|(?P<power>\^)|(?P<sub>_)'
    rf'|(?P<parameter>(?!(?:{WORDS})_)[A-Za-z]{{3,}}(?:_[A-Za-z]{{2,}})+)'
    r'|(?P<name>[A-Za-z][A-Za-z0-9]*)|(?P<number>\d+(?:[.,]\d+)*(?:e-?\d+)?)'
    r'|(?P<sign><=|>=|->|\+-|-\+|\.\.\.|.)'
)
# A unit alone, as `mm.`, which would be the number 2000 of a list.
ENUMERATED = re.compile(r'^(\s*[A-Za-z]{1,3})\.(?=\s|$)')
# A block with one of these is a command or a program, one without any of those says nothing.
PROGRAM = re.compile(
    r"^(?:import|from|for|if|python|ros2|make|pip|\$|>>>)\b|\w\(\w+=|'\w{2,}|:=|--\w"
)
RELATION = re.compile(r'(?<![<>=!])=(?!=)|<=|>=|<|>|->|\^|sqrt|sum_|\[.+\]|\w\(.+\)')


def typeset(lines: list[str]) -> list[str]:
    """
    Return the lines of a docstring with its equations in directives.

    Parameters
    ----------
    lines : list of str
        Of the docstring, without the indentation of the code.

    Returns
    -------
    list of str
        A block that is no equation, as a command line, becomes a literal block.

    """
    found: list[str] = []
    before = 0  # columns of the last line of text
    index = 0
    while index < len(lines):
        line = lines[index]
        column = len(line) - len(line.lstrip())
        set_off = found and not found[-1].strip() and column >= before + INDENT
        if not line.strip() or not set_off:
            found.append(ENUMERATED.sub(r'\1\\.', line.replace('|', r'\|')))
            before = column if line.strip() else before
            index += 1
            continue
        block = list(_block(lines[index:], column))
        index += len(block)
        literal = any(each.rstrip().endswith('::') for each in found[-2:])
        found += block if literal else _directive(block, before)
    return found


def latex(line: str) -> str:
    """
    Return a line of mathematics as LaTeX.

    Parameters
    ----------
    line : str
        As in `I_pq = sum_k (d mu_k / d p)(d mu_k / d q) / V_k`.

    """
    return _row([(str(each.lastgroup), each[0]) for each in TOKEN.finditer(line.strip())])


def _block(lines: list[str], column: int) -> Iterator[str]:
    """Yield the first lines that are set off, with the blank ones between them."""
    end = 0
    for number, line in enumerate(lines):
        if line.strip() and len(line) - len(line.lstrip()) < column:
            break
        if line.strip():
            end = number + 1
    yield from lines[:end]


def _directive(block: list[str], column: int) -> list[str]:
    """Return a block as mathematics, or literally."""
    margin = ' ' * column
    written = [line for line in block if line.strip()]
    if any(PROGRAM.search(line.strip()) or not RELATION.search(line) for line in written[:1]):
        return [f'{margin}::', '', *block]
    rows = [f'{margin}   & {latex(line)}' + r' \\' for line in written]
    return [
        f'{margin}.. math::', '', rf'{margin}   \begin{{aligned}}', *rows,
        rf'{margin}   \end{{aligned}}',
    ]


def _row(tokens: list[tuple[str, str]]) -> str:
    """Return tokens as LaTeX, what is in brackets by the same rule."""
    parts: list[str] = []
    place = 0
    while place < len(tokens):
        kind, text = tokens[place]
        place += 1
        if kind == 'gap':
            parts.append(r' \qquad ')
        elif kind in ('power', 'sub'):
            mark = '^' if kind == 'power' else '_'
            inside, place = _script(tokens, place)
            parts.append(f'{mark}{{{inside}}}' if inside else rf'\{mark}')
        elif text == 'sqrt' and place < len(tokens) and tokens[place][1] == '(':
            end = _closing(tokens, place)
            parts.append(rf'\sqrt{{{_row(tokens[place + 1:end])}}}')
            place = end + 1
        elif kind == 'parameter':
            parts.append(r'\mathrm{%s}' % text.replace('_', r'\_'))
        elif kind == 'name':
            called = place < len(tokens) and tokens[place][1] == '('
            parts.append(_name(text, called, _beside_a_name(tokens, place - 1)))
        else:
            parts.append(SIGNS.get(text, text))
    return ''.join(parts).strip()


def _script(tokens: list[tuple[str, str]], place: int) -> tuple[str, int]:
    """Return what is raised or lowered, and the place after it."""
    sign = ''
    if place < len(tokens) and tokens[place][1] in '+-':
        sign, place = tokens[place][1], place + 1
    if place == len(tokens) or tokens[place][0] in ('space', 'gap'):
        return sign, place
    kind, text = tokens[place]
    if text == '(':
        end = _closing(tokens, place)
        return sign + _row(tokens[place + 1:end]), end + 1
    if kind == 'name' and (len(text) > 2 or text in GREEK):  # two letters are two indices
        text = _name(text, False, False).strip()
    return sign + text, place + 1


def _closing(tokens: list[tuple[str, str]], place: int) -> int:
    """Return where the bracket that opens here is closed; the end where it is not."""
    depth = 0
    for end in range(place, len(tokens)):
        depth += {'(': 1, ')': -1}.get(tokens[end][1], 0)
        if depth == 0:
            return end
    return len(tokens) - 1


def _beside_a_name(tokens: list[tuple[str, str]], place: int) -> bool:
    """Tell whether a name follows on a name, with a space between: these are words."""
    return any(
        0 <= place + 2 * way < len(tokens) and tokens[place + way][0] == 'space'
        and tokens[place + 2 * way][0] == 'name' for way in (-1, 1)
    )


def _name(text: str, called: bool, in_words: bool) -> str:
    """Return a name: a letter, a Greek one, a function, a word."""
    if text in NAMED:
        return NAMED[text]
    if text.lower() in GREEK:
        return rf'\{text} '
    if text in FUNCTIONS:
        return rf'\{text} '
    if len(text) == 1 or re.fullmatch('d[a-z]', text):
        return text
    if numbered := re.fullmatch(r'([A-Za-z])(\d+)', text):
        return f'{numbered[1]}_{{{numbered[2]}}}'
    if called:
        return rf'\operatorname{{{text}}}'
    return rf'\ \text{{{text}}}\ ' if in_words else rf'\mathrm{{{text}}}'
