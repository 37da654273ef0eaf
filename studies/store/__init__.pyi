from .column_sets import (
    ANGLES as ANGLES,
    CONSTANTS as CONSTANTS,
    DEVIATIONS as DEVIATIONS,
    METRES as METRES,
    POINT_LABELS as POINT_LABELS,
    TRIAL as TRIAL,
    described as described,
    unit_of_unknown as unit_of_unknown,
)
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
from .status_codes import (
    CODES as CODES,
    CONVERGED as CONVERGED,
    CRASHED as CRASHED,
    LOST as LOST,
    NO_NOMINAL as NO_NOMINAL,
    OTHER as OTHER,
    SENTENCES as SENTENCES,
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
    other_program as other_program,
    programs_of as programs_of,
    refuse_other as refuse_other,
    study_of as study_of,
)
