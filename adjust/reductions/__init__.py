"""From machine coordinates to image coordinates: reductions, each of which says what it removed.

They need no adjustment, and the adjustment needs none of them.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
