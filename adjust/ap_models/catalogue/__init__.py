"""The published sets, one family a file, each with its source and how sure its formula is.

A new set is declared here and named in adjust/ap_models/lookup.py.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
