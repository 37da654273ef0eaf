"""What a reader gets: reports of studies, scenarios and sets, as Markdown and as one HTML file.

Numbers come from elsewhere.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
