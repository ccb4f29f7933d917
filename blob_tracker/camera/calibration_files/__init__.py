"""Calibration files of other people's programs, a file for each form."""
