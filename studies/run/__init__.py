"""A study run: processes, clusters, crashes, going on where it was left; `story` tells it.

None of it touches the results.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
