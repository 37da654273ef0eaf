"""The command line, one file a group of commands; nothing is computed here.

Everything heavy is imported inside the commands, so that --help answers at once.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
