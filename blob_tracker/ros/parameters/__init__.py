"""Parameters of a node: declared, checked, changed while it runs; the files that they name."""
