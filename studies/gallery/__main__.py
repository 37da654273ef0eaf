"""python -m studies.gallery [FOLDER]: draw the gallery and the picture of the front page."""

import sys
from pathlib import Path

from studies.gallery.gallery import write
from studies.gallery.overview import write_overview

if __name__ == "__main__":
    docs = Path(sys.argv[1] if len(sys.argv) > 1 else "docs")
    for path in (*write(docs), write_overview(docs)):
        print(path)
