from .story import reproduce as reproduce
