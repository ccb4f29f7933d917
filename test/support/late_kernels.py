"""Kernels that machine code is looked for while a program runs: none after `compile_ahead`."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

from blob_tracker import kernel


def run_alone(program: str) -> None:
    """Run a program in a process of its own: the tests here may have loaded any kernel."""
    environment = os.environ | {'PYTHONPATH': os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, '-c', program], check=True, env=environment)


def late_kernels() -> list[str]:
    """Return a list to which the names go of what is loaded, or compiled, from now on."""
    late: list[str] = []
    missed = kernel._Kernel.missed

    def noted(each: Any, *arguments: Any, **named: Any) -> Any:
        late.append(f'{each.py_func.__module__}.{each.py_func.__qualname__}')
        return missed(each, *arguments, **named)

    setattr(kernel._Kernel, 'missed', noted)
    return late
