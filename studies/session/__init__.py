"""This installation, this machine and this run: what is installed, what results came from, how far a command is.

Nothing here touches a result.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
