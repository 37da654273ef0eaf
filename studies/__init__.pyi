from . import figures as figures
from .comparison import measures as measures
