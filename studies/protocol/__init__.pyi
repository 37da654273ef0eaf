from . import adjustment_page as adjustment_page, files as files
