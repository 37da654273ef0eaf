from .brown import Brown1971 as Brown1971, Brown1976 as Brown1976
from .elhakim_faig import ElHakimFaig11 as ElHakimFaig11
from .jacobsen import Jacobsen12 as Jacobsen12
from .koelbl_juhl import KoelblJuhl9 as KoelblJuhl9
from .mauelshagen import (
    Brown14 as Brown14,
    Mauelshagen14 as Mauelshagen14,
    NoModel as NoModel,
    Optical as Optical,
    Torlegard as Torlegard,
)
from .orthogonal import (
    Chebyshev as Chebyshev,
    Ebner12 as Ebner12,
    Fourier as Fourier,
    Gruen12 as Gruen12,
    Gruen44 as Gruen44,
    Legendre as Legendre,
    Zernike as Zernike,
)
from .salmenpera_kilpela import SalmenperaKilpela7 as SalmenperaKilpela7
from .schut import Schut14 as Schut14
