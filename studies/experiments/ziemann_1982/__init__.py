"""Ziemann and El-Hakim 1982: eight sets of additional parameters on two test fields, compared again.

`story` tells it.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
