"""Thousands of trials of one geometry, by chord iterations in lanes, with the minimum that `adjust_block` finds.

A trial that does not contract is finished by Gauss-Newton, and counted.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
