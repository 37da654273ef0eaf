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
    refuse_other as refuse_other,
    study_of as study_of,
)
