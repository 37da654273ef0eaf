"""One file a kind of observation: residuals, derivatives and weights.

`group` says what a kind must be able to do.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
