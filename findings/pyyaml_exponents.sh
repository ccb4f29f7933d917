#!/usr/bin/env bash
# PyYAML reads 1e-3 and 1.5e3 as text.
#
# Expected: numbers, as in JSON, of which YAML is said to be a superset, and in every language that
# has such numbers.
# Happens: a number with an exponent needs a dot and a sign of the exponent for PyYAML, 1.0e-3 and
# 1.5e+3, as YAML 1.1 wants it. Anything else is a string. What json.dumps and Python's own text
# of a number make of 0.00001 lacks the dot.
# Matters: a value that was always read becomes text when it is small enough, or when somebody
# writes 1e-3 for 0.001. A string is true, and 3 times it is a longer string.
#
# PyYAML 6.0.3:
#   0.001: 0.001
#   1.0e-3: 0.001
#   1e-3: '1e-3'
#   1.5e3: '1.5e3'
#   json.dumps of 0.0001 and 0.00001: 0.0001 '1e-05'
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    pyyaml==6.0.3
"$folder/venv/bin/python" -I - <<'END'
import json

import yaml

as_described = True
for text, expected in (
        ('0.001', 0.001), ('1.0e-3', 0.001), ('1e-3', '1e-3'), ('1.5e3', '1.5e3')):
    found = yaml.safe_load(text)
    print(f'{text}: {found!r}')
    as_described &= found == expected

read = [yaml.safe_load(json.dumps(number)) for number in (0.0001, 0.00001)]
print('json.dumps of 0.0001 and 0.00001:', *map(repr, read))
if not (as_described and read == [0.0001, '1e-05']):
    raise SystemExit('PyYAML no longer reads 1e-3 as text.')
END
