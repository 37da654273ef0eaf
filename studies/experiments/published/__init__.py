"""Published tables as printed, with their sources.

What is known to be misprinted is said beside them.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
