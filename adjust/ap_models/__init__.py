"""Sets of additional parameters: `names()` lists the ids, `get(id, **settings)` makes one.

A set is a table of terms; the catalogue has the published ones, and `own` loads those of a user.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
