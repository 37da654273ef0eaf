"""From light to number: air, lens, film, marks and comparator, stage by stage, each to be switched off.

`adjust.reductions` goes the way back.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
