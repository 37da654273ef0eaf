from .tables import (
    mauelshagen_table1 as mauelshagen_table1,
    mauelshagen_table2 as mauelshagen_table2,
    source as source,
    ziemann_el_hakim as ziemann_el_hakim,
)
