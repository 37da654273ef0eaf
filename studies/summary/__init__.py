"""From columns to rows: measures with their Monte-Carlo standard errors, ranks, and when to stop.

It computes from shards alone, so that a summary can always be made anew.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
