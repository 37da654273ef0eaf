"""A block, or a measured file, to files and back without losing a bit; every refusal names file, row and column.

What is written is written whole or not at all.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
