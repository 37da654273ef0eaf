"""Normal equations: made, reduced, factorised and inverted; once to be read, and once compiled.

What is unknown and what is observed is decided elsewhere.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
