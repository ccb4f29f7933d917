"""Runs studies and writes down what they find."""
