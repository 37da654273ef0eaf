"""Figures: functions of an axes and data.

They know no paths and compute nothing that is not drawn.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
