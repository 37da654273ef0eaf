from .look import Shard as Shard, joined as joined, look_at as look_at
from .shards import (
    BEFORE as BEFORE,
    MOST_BYTES as MOST_BYTES,
    Columns as Columns,
    DamageError as DamageError,
    ForeignError as ForeignError,
    decode as decode,
    encode as encode,
)
from .store import (
    NOMINAL as NOMINAL,
    LockedError as LockedError,
    Store as Store,
    StoreError as StoreError,
    locked as locked,
    read_json as read_json,
)
from .stored_study import (
    MOST_DIFFERENCES as MOST_DIFFERENCES,
    _differences as _differences,
    _levels as _levels,
    study_of as study_of,
)
