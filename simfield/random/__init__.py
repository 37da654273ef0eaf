"""Named streams of random numbers, and normal numbers by counter: the same whatever the order in which they are asked
for.

It knows nothing of what is drawn.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
