"""What is probably wrong with a block: units, axes, origins, branches, names, and what contradicts what.

Before adjusting, the tables are held against each other; afterwards, the result against them. Nothing is changed.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
