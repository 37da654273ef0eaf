"""The trials of one condition: drawn, measured, adjusted by every method, turned into columns.

It knows neither processes nor files.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
