from . import properties as properties
from .catalogue.brown import Brown1971 as Brown1971, Brown1976 as Brown1976
from .catalogue.ebner import Ebner12 as Ebner12
from .catalogue.elhakim_faig import ElHakimFaig11 as ElHakimFaig11
from .catalogue.fourier import Fourier as Fourier
from .catalogue.gruen import Gruen12 as Gruen12, Gruen44 as Gruen44
from .catalogue.jacobsen import Jacobsen12 as Jacobsen12
from .catalogue.koelbl_juhl import KoelblJuhl9 as KoelblJuhl9
from .catalogue.mauelshagen import (
    Brown14 as Brown14,
    Mauelshagen14 as Mauelshagen14,
    NoModel as NoModel,
    Optical as Optical,
    Torlegard as Torlegard,
)
from .catalogue.products import Chebyshev as Chebyshev, Legendre as Legendre
from .catalogue.salmenpera_kilpela import SalmenperaKilpela7 as SalmenperaKilpela7
from .catalogue.schut import Schut14 as Schut14
from .catalogue.zernike import Zernike as Zernike
from .lookup import MODELS as MODELS, get as get, names as names
from .model import ApModel as ApModel, Certainty as Certainty
from .own import own_model as own_model
from .restricted import without as without
