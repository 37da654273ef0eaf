from .block import (
    COORDINATES as COORDINATES,
    EXTERIOR as EXTERIOR,
    ROLES as ROLES,
    SIGMAS as SIGMAS,
    Block as Block,
    BlockError as BlockError,
    Camera as Camera,
    ImageObservations as ImageObservations,
    Images as Images,
    Points as Points,
)
from .checks import Floats as Floats, Indices as Indices
from .further import (
    ATTITUDE as ATTITUDE,
    POSITION as POSITION,
    SIGMA_ATTITUDE as SIGMA_ATTITUDE,
    SIGMA_POSITION as SIGMA_POSITION,
    TABLES as TABLES,
    Further as Further,
    Lines as Lines,
    Priors as Priors,
    Stations as Stations,
    Strips as Strips,
)
from .raw import Raw as Raw
from .wording import nearest as nearest, resembling as resembling, shown as shown
