"""What a surveyor hands over: the data model of a block and of a measured file, validated and read-only.

It knows no file, no formula and no truth; shared with the adjustment.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
