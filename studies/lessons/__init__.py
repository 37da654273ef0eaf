"""Lessons: a question, two or three controls, an answer computed live. `simfield teach` shows them in the browser.

What a lesson computes stands here, one file a lesson; its page is in apps/.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
