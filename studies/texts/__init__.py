"""Markdown, HTML, tables and SVG that are safe to show, whatever names and labels hold.

It knows no photogrammetry.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
