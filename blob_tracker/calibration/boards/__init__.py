"""The calibration boards, one file for each kind: an image in, points and their places out."""

from blob_tracker.calibration.boards.board import Board, BoardError, View
from blob_tracker.calibration.boards.charuco import CharucoBoard
from blob_tracker.calibration.boards.chessboard import Chessboard
from blob_tracker.calibration.boards.dot_grid import DotGrid

__all__ = ['Board', 'BoardError', 'CharucoBoard', 'Chessboard', 'DotGrid', 'View']
