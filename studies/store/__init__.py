"""A folder in which a shard exists if and only if it is whole.

The folder is the truth: what is not there is computed, what is damaged is computed again.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
