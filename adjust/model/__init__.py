"""What is unknown, and how a point becomes an image point: rotation, collinearity, the order of the unknowns.

Whose additional parameters there are is decided here too.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
