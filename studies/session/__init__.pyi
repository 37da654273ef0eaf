from . import installation as installation
from .host import computer as computer, processor as processor
from .installation import versions as versions
from .origin import provenance as provenance
from .progress import progress_bar as progress_bar
from .which_program import program as program
