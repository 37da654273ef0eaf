from .counter_normals import Words as Words, normal_pairs as normal_pairs, words as words
from .counter_normals_compiled import (
    HALF as HALF,
    PERIOD as PERIOD,
    WORD as WORD,
    ZERO as ZERO,
    draw as draw,
    drawn_of as drawn_of,
    fill as fill,
    philox as philox,
)
from .streams import counter_key as counter_key, name_words as name_words, stream as stream
