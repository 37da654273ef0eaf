"""Markdown becomes HTML without links and without HTML of its own."""

from studies.texts.inline_svg import Drawing
from studies.texts.markdown_html import converted
from studies.texts.markdown_text import escaped, fenced

HOSTILE = "<script>alert(1)</script> [x](https://example.org) <https://example.org> `a` *b* | $c$ & \\ ~~d~~"


def figure(name, title):
    return Drawing(900.0, 6.0, f"{title} & {name}", "says <it>", "<svg></svg>")


def test_the_text_of_others_stands_as_it_is():
    page = converted(f"# {escaped(HOSTILE)}\n\n{escaped(HOSTILE)}\n\n| {escaped(HOSTILE)} |\n| --- |\n| x |\n", figure)
    assert page.title == HOSTILE
    shown = HOSTILE.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert f"<p>{shown}</p>" in page.body
    assert f'<th scope="col">{shown}</th>' in page.body


def test_html_and_links_in_markdown_do_nothing():
    page = converted("<script>x</script>\n\n[a](javascript:x) <https://b.org>\n\n[c]: https://c.org\n\n[c]\n", figure)
    assert "<script" not in page.body
    assert "<a" not in page.body
    assert "href" not in page.body


def test_figures_stand_alone_with_their_caption():
    page = converted("![T](a.svg)\n\n![U](b.svg) text\n", figure)
    assert page.body.startswith('<figure class="wide scrolls"')
    assert "<figcaption><b>T &amp; a.svg.</b> says &lt;it&gt;</figcaption></figure>" in page.body
    assert page.body.count("<p>") == 1


def test_sections_have_anchors_of_their_own():
    page = converted("# Title\n\n## One `two`\n\n## One two\n", figure)
    (first, said), (second, _) = page.sections
    assert said == "One two"
    assert first != second
    assert f'<h2 id="{first}">' in page.body
    assert "<h1" not in page.body


def test_tables_scroll_on_their_own():
    page = converted("| a | b |\n| --- | ---: |\n| 1 | 2 |\n", figure)
    assert page.body.startswith('<div class="table" role="region" aria-label="table" tabindex="0"><table>')
    assert '<th scope="col" style="text-align:right">b</th>' in page.body


def test_small_letters_widen_a_figure():
    """900 pt with letters of 6 pt must not be drawn narrower than 900 * 6.9 / 6."""
    assert "--natural:900pt;--least:1035pt" in converted("![T](a.svg)\n", figure).body


def test_columns_of_numbers_stand_flush_right():
    rows = "| 5 | -0.2 ± 0.1 | 41 (32–52) | 1e-05 | 5.4? / 5.51 | 3.1.1 or so | – |\n"
    page = converted(f"| a | b | c | d | e | f | g |\n|{' --- |' * 7}\n{rows}{rows}", figure)
    assert page.body.count('<td style="text-align:right">') == 12
    assert page.body.count("<td>3.1.1 or so</td>") == 2
    assert '<th scope="col">f</th>' in page.body


def test_lines_end_at_good_places():
    page = converted("5 % of 3 um, 2 umbrellas\n\n| `x` um_at_100mm |\n| --- |\n| a |\n", figure)
    assert "5\u00a0% of 3\u00a0um, 2 umbrellas" in page.body
    assert '<th scope="col"><code>x</code> um_<wbr>at_<wbr>100mm</th>' in page.body


def test_an_option_is_not_torn_at_its_dashes():
    page = converted(fenced("simfield run --trials 5 -- <b>"), figure)
    assert "<pre><code>simfield run <span>--trials</span> 5 -- &lt;b&gt;\n</code></pre>" in page.body


def test_a_fence_is_longer_than_any_in_the_text():
    text = 'question = """\n```\n<b>````\n"""'
    page = converted(fenced(text), figure)
    assert page.body.count("<pre>") == 1
    assert "````" in page.body
    assert "&lt;b&gt;" in page.body
