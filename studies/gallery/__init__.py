"""Every kind of figure, on one experiment: `python -m studies.gallery docs` draws them.

It computes nothing of its own.
"""
