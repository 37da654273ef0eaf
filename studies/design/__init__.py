"""The study file: question, factors, conditions and methods, laid out as a plan; and the studies that ship.

A dry run needs no more than this, so nothing here is heavy.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
