"""Only drawings get into a page: what else an SVG can hold is refused, and figures do not share ids."""

import re

import pytest

from studies.figures.canvas import house_style, literal, new_figure, svg
from studies.texts.inline_svg import DrawingError, inline

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="10pt" viewBox="0 0 1 1"'
)


def drawing(label="a label", title="Title & <b>", says="What it shows"):
    with house_style():
        figure = new_figure(60, 40)
        axes = figure.subplots()
        axes.pcolormesh([[0.0, 1.0], [2.0, 3.0]])
        axes.plot([0, 1], label=label)
        axes.set_title(label)
        axes.legend()
        figure.colorbar(axes.collections[0], ax=axes)
        return svg(figure, title, says)


def test_a_figure_of_ours_passes_with_its_alternative_text():
    found = inline(drawing(), 3)
    assert found.markup.startswith("<svg ")
    assert 'role="img" aria-label="Title &amp; &lt;b&gt;" aria-describedby="f3-says"' in found.markup
    assert '<title>Title &amp; &lt;b&gt;</title><desc id="f3-says">What it shows</desc>' in found.markup
    assert (found.title, found.says) == ("Title & <b>", "What it shows")
    assert found.width_pt == pytest.approx(60 / 25.4 * 72, rel=0.01)
    assert found.letter_pt == pytest.approx(8.5)  # of the house style
    assert "<path" in found.markup


def test_every_reference_inside_a_figure_still_finds_its_id():
    found = inline(drawing(), 1).markup
    ids = set(re.findall(r' id="([^"]+)"', found))
    references = set(re.findall(r'(?:href="|url\()#([^")]+)', found))
    assert references
    assert references <= ids
    other = set(re.findall(r' id="([^"]+)"', inline(drawing(), 2).markup))
    assert not ids & other


def test_a_title_from_outside_is_used_where_the_file_has_none():
    assert inline(drawing(title=""), 1, "from the page").title == "from the page"


@pytest.mark.parametrize(
    "body",
    [
        "><script>alert(1)</script></svg>",
        "><g><SCRIPT/></g></svg>",
        '><path d="M0 0" onclick="alert(1)"/></svg>',
        '><a xlink:href="https://example.org"><path d="M0 0"/></a></svg>',
        '><use xlink:href="https://example.org/x.svg#a"/></svg>',
        '><use href="#a"/></svg>',
        '><image xlink:href="javascript:alert(1)"/></svg>',
        '><image xlink:href="data:image/svg+xml;base64,AAAA"/></svg>',
        '><path xlink:href="data:image/png;base64,AAAA"/></svg>',
        "><foreignObject><p>text</p></foreignObject></svg>",
        '><g style="fill: url(https://example.org/x)"/></svg>',
        '><g clip-path="url(https://example.org/x)"/></svg>',
        "><g style=\"background: url('x')\"/></svg>",
        "><h:p xmlns:h='http://www.w3.org/1999/xhtml'>text</h:p></svg>",
        "><g></svg>",
        "",
    ],
)
def test_what_no_figure_has_is_refused(body):
    with pytest.raises(DrawingError) as refused:
        inline(HEAD + body, 1)
    assert len(str(refused.value).splitlines()) == 1


def test_the_outermost_element_is_written_anew():
    assert "onload" not in inline(HEAD + ' onload="alert(1)"></svg>', 1).markup


def test_entities_are_refused_before_they_are_read():
    with pytest.raises(DrawingError, match="entities"):
        inline('<!DOCTYPE svg [<!ENTITY a "aaaa">]>' + HEAD + ">&a;</svg>", 1)


@pytest.mark.parametrize("label", [r"$\frac$", "$x$", "_hidden", "<script>", "a\x07b", "\U0001f600"])
def test_labels_are_drawn_as_they_stand(label):
    """With formulas parsed, `$\\frac$` would end the drawing, and `_hidden` would not be in the legend."""
    drawn = drawing(literal(label))
    assert inline(drawn, 1).markup
    escaped = label.replace("<", "&lt;").replace(">", "&gt;").replace("\x07", "�")
    assert drawn.count(f"<!-- {escaped} -->") + drawn.count(f"<!--  {escaped} -->") == 2  # title and legend


def test_a_label_ends():
    assert len(literal("x" * 1000)) == 60
    assert literal(" a \n b ") == "a b"
