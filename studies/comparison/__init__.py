"""Where truth and estimate meet, and nowhere else: errors of points, orientations and distortion.

One adjustment against one truth; many trials are summarised elsewhere.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
