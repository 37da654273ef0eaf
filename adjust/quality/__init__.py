"""How good an adjustment is: reliability, gross errors, variance components, significance, choice of a model.

It never touches the trials.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
