"""What moves an image point: lens, film and noise, in one trial or in thousands.

Distortion is written a second time in the adjustment, by other means, so that a shared error cannot cancel.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
