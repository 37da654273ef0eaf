from . import compile_notice as compile_notice, lanes_compiled as lanes_compiled, machine_code as machine_code
from .arena import Arena as Arena
from .blas_threads import one_thread as one_thread
from .lanes import (
    TOGETHER as TOGETHER,
    WIDTH as WIDTH,
    WIDTH_SINGLE as WIDTH_SINGLE,
    align_stack as align_stack,
    any_above as any_above,
    choose as choose,
    equal as equal,
    greater as greater,
    least as least,
    load as load,
    narrow as narrow,
    root as root,
    same as same,
    store as store,
    whole as whole,
    widen as widen,
)
from .lanes_compiled import inlined as inlined, kernel as kernel
