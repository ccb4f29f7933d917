"""The runner of the studies: kept results, failures, interruption, a cluster; and its report."""

from __future__ import annotations

from html.parser import HTMLParser
from math import isnan
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from blob_tracker.__main__ import main
from blob_tracker.studies import command, registry, run, workers
from blob_tracker.studies.kept import Kept
from blob_tracker.studies.study import Check, Findings, Study, Table
from distributed import LocalCluster
from matplotlib.figure import Figure
import pytest
