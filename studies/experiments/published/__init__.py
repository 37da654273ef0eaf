"""Published tables as printed, with their sources.

What is known to be misprinted is said beside them.
"""
