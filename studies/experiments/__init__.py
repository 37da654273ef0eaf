"""Experiments with a command of their own, one folder a paper; published/ has their tables as printed.

Each is told by its `story`.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
