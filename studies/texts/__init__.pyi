from .inline_svg import MOST_BYTES as MOST_BYTES, Drawing as Drawing, DrawingError as DrawingError, inline as inline
from .markdown_html import converted as converted
from .markdown_text import escaped as escaped, fenced as fenced, unbroken as unbroken
from .spreadsheet import FORMULA as FORMULA, as_text as as_text
from .tables import DASH as DASH, markdown as markdown, write_csv as write_csv
