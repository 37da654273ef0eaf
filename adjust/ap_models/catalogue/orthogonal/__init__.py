"""Sets made of functions that are orthogonal over the format: polynomials of Ebner and Grün, products, Zernike's.

Where image points lie on a regular grid, the parameters do not depend on each other.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
