from .air import Air as Air
from .chain_file import chain_as_table as chain_as_table, chain_from_table as chain_from_table
from .comparator import Comparator as Comparator, Errors as Errors, Marks as Marks
from .lens import Lens as Lens, RadialCertificate as RadialCertificate
from .measure import (
    FILM as FILM,
    Chain as Chain,
    PreparedChain as PreparedChain,
    prepare as prepare,
    share_of_words as share_of_words,
)
from .measure_compiled import (
    Room as Room,
    below_share as below_share,
    gross_errors as gross_errors,
    is_deformed as is_deformed,
    on_machine as on_machine,
    set_marks as set_marks,
    smooth_field as smooth_field,
    take_image as take_image,
)
from .measure_tables import tables as tables
from .presets import STAGES as STAGES, chains as chains, without as without
from .random_field import RandomField as RandomField
