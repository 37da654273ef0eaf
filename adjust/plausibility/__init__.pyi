from .checking import before as before, checked as checked
from .finding import Finding as Finding, Severity as Severity
