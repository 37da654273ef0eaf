"""Experiments with a command of their own, one folder a paper; published/ has their tables as printed.

Each is told by its `story`.
"""
