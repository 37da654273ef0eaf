"""The directive `ap-catalogue`: every set of additional parameters, as `simfield models ID` describes it."""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from adjust.ap_models import MODELS
from studies.pages import describe


class Catalogue(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        found: list[nodes.Node] = []
        for model in (kind() for kind in MODELS):
            section = nodes.section(ids=[nodes.make_id(f"set-{model.id}")])
            text = describe(model).split("\n", 2)[2].rstrip()
            section += nodes.title(text=model.id)
            section += nodes.paragraph(text=f"{model.title}.")
            section += nodes.literal_block(text, text, language="none")
            self.state.document.note_explicit_target(section)
            found.append(section)
        return found


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("ap-catalogue", Catalogue)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
