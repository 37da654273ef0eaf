"""Questions put many times, and everything that is told to people: the only place where truth and estimate meet.

`simfield --help` shows it from outside; `run` tells its story.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
