"""Measurements: this engine beside general solvers, on the same block and the same noise. See README.md."""
