from .ebner import Ebner12 as Ebner12
from .fourier import Fourier as Fourier
from .gruen import Gruen12 as Gruen12, Gruen44 as Gruen44
from .products import Chebyshev as Chebyshev, Legendre as Legendre
from .zernike import Zernike as Zernike
