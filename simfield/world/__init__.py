"""What there is before anything goes wrong: fields, cameras, flights, ideal images, and which points an image shows.

Deviations of flights and omitted points belong here, errors of image points do not.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
