"""From a block to estimates and their quality.

The story is told by bundle.py, the answer is an Adjustment. Nothing behind this door is loaded before it is asked for.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
