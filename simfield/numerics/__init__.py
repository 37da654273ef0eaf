"""How numbers are computed: vector registers (lanes), memory that is used again, threads, and when something compiles.

No photogrammetry; shared with the adjustment.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
