"""Accuracy and speed of the location methods beside other people's, on the same windows."""
