"""The experiments of chapter 5 of the thesis, in the virtual lab."""
