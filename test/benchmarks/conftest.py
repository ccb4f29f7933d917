"""The benchmarks are not installed: they are found in the checkout, behind all that is."""

from pathlib import Path
import sys

sys.path.append(str(Path(__file__).parents[2]))
