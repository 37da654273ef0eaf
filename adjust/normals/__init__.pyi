from .arithmetic import Arithmetic as Arithmetic
from .cofactors import Cofactors as Cofactors
from .either import by_either as by_either
from .loops_compiled import add_rays as add_rays
from .normals import FactorisedNormals as FactorisedNormals, Plain as Plain, SingularError as SingularError
from .normals_compiled import Compiled as Compiled
from .told_cofactors import ToldCofactors as ToldCofactors
