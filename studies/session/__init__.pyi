from . import installation as installation
from .host import machine as machine, processor as processor
from .installation import versions as versions
from .origin import provenance as provenance
from .progress import progress_bar as progress_bar
