"""From start values to the minimum, or a sentence that says why there is none.

Start values, iteration, rank defects and what is too badly determined.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
