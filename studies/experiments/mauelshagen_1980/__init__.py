"""Mauelshagen 1980, flown and adjusted again: its tables, claims and figures beside the published ones.

`story` tells it.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
