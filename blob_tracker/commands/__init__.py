"""What `python3 -m blob_tracker` starts, one module or folder for each command."""
