"""The protocol of one adjustment: reliability, suspected errors, correlations, advice; as text, JSON and tables.

It sees the adjustment only, never a truth.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
