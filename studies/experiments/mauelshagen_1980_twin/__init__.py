"""Worlds in which the published table of 1980 happens: fitted, flown and adjusted.

The fit uses the table itself, so it is no test.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
