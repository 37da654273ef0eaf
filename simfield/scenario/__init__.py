"""Everything that has to be said about an experiment: values, their file, changes by dotted path, and the presets.

A fault is named with its place and with what is allowed.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
