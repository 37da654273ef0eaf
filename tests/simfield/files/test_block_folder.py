# Over 300 lines: every defect of a file, one table after the other
"""The block folder loses no bit, and refuses every defect in one line with file, row and column."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from simfield.block.block import ROLES, Block, Camera, ImageObservations, Images, Points
from simfield.block.checks import SIGMA_LEAST, SIGMA_MOST
from simfield.files.block_folder import BlockFolderError, read_block, write_block

FILES = {
    "cameras.csv": "camera_id,c_mm,x0_mm,y0_mm,width_mm,height_mm\nww,153.0,0.01,-0.02,230.0,230.0\n",
    "images.csv": "image_id,camera_id,X0_m,Y0_m,Z0_m,omega_deg,phi_deg,kappa_deg\n"
    "a,ww,10.5,-20.25,1500.0,0.1,-0.2,90.0\n"
    "b,ww,,,,,,\n",
    "points.csv": "point_id,role,X_m,Y_m,Z_m,sigma_X_m,sigma_Y_m,sigma_Z_m\n"
    "1,control,1.0,2.0,3.0,0.0,0.01,\n"
    "2,check,4.0,5.0,6.0,,,\n"
    "3,tie,,,,,,\n",
    "observations.csv": "image_id,point_id,x_mm,y_mm,sigma_x_mm,sigma_y_mm\n"
    "a,1,1.5,-2.5,0.005,0.005\n"
    "a,2,3.0,4.0,0.005,0.005\n"
    "a,3,5.0,6.0,0.005,0.005\n"
    "b,1,-1.5,2.5,0.005,0.005\n"
    "b,2,-3.0,-4.0,0.005,0.005\n"
    "b,3,-5.0,-6.0,0.005,0.005\n",
}
SXB = Path(os.environ.get("SIMFIELD_SXB", Path(__file__).parents[3] / "../shared/data/sxb"))
SECONDS_FOR_A_BOMB = 20.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8", newline="")
    return tmp_path


def contents(folder: Path) -> dict[str, str]:
    return {file.name: file.read_text(encoding="utf-8") for file in folder.iterdir()}


def bits(array: Any) -> bytes:
    """The bytes of an array with every NaN the same NaN, so that -0.0 differs from 0.0 but NaN equals NaN."""
    return np.where(np.isnan(array), np.nan, array).tobytes()


def assert_same(one: Block, other: Block) -> None:
    assert one.cameras == other.cameras
    assert (one.images.ids, one.points.ids) == (other.images.ids, other.points.ids)
    assert one.images.camera.tolist() == other.images.camera.tolist()
    assert one.points.role.tolist() == other.points.role.tolist()
    assert bits(one.images.exterior) == bits(other.images.exterior)
    assert bits(one.points.coordinates) == bits(other.points.coordinates)
    assert bits(one.points.sigma) == bits(other.points.sigma)
    assert one.observations.image.tolist() == other.observations.image.tolist()
    assert one.observations.point.tolist() == other.observations.point.tolist()
    assert bits(one.observations.xy) == bits(other.observations.xy)
    assert bits(one.observations.sigma) == bits(other.observations.sigma)


def refusal(folder: Path) -> BlockFolderError:
    with pytest.raises(BlockFolderError) as caught:
        read_block(folder)
    assert len(str(caught.value).splitlines()) == 1
    return caught.value


# Round trip


def test_a_folder_is_read_into_metres_millimetres_and_radians(folder: Path) -> None:
    block = read_block(folder)
    assert block.cameras == (Camera("ww", 153.0, 0.01, -0.02, 230.0, 230.0),)
    assert block.images.exterior[0, :3].tolist() == [10.5, -20.25, 1500.0]
    assert block.images.exterior[0, 5] == np.pi / 2
    assert np.isnan(block.images.exterior[1]).all()
    assert block.points.role.tolist() == ["control", "check", "tie"]
    assert block.points.fixed[0].tolist() == [True, False, False]
    assert np.isnan(block.points.coordinates[2]).all()
    assert block.observations.xy[0].tolist() == [1.5, -2.5]


def test_a_short_folder_is_written_back_letter_by_letter(folder: Path) -> None:
    write_block(read_block(str(folder)), folder / "new" / "copy")
    assert contents(folder / "new" / "copy") == FILES


any_float = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(SIGMA_LEAST, SIGMA_MOST)
maybe = st.one_of(st.just(np.nan), any_float)
angle = st.floats(-4 * np.pi, 4 * np.pi)
an_id = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0\r"), min_size=1, max_size=8).filter(
    lambda text: text == text.strip()
)


@st.composite
def blocks(draw: st.DrawFn) -> Block:
    """A block of any numbers whatever, with any names, complete in its observations."""
    cameras, images, points = draw(st.integers(1, 2)), draw(st.integers(2, 3)), draw(st.integers(1, 4))

    def ids(count: int) -> tuple[str, ...]:
        return tuple(draw(st.lists(an_id, min_size=count, max_size=count, unique=True)))

    def table(strategy: st.SearchStrategy[float], rows: int, columns: int) -> Any:
        size = rows * columns
        return np.array(draw(st.lists(strategy, min_size=size, max_size=size))).reshape(rows, columns)

    exterior = np.hstack([table(any_float, images, 3), table(angle, images, 3)])
    exterior[draw(st.lists(st.booleans(), min_size=images, max_size=images))] = np.nan
    coordinates = table(maybe, points, 3)
    sigma = np.where(
        np.isnan(coordinates), np.nan, table(st.one_of(st.sampled_from([np.nan, 0.0]), positive), points, 3)
    )
    return Block(
        tuple(
            Camera(name, draw(positive), draw(any_float), draw(any_float), draw(positive), draw(positive))
            for name in ids(cameras)
        ),
        Images(ids(images), np.array([draw(st.integers(0, cameras - 1)) for _ in range(images)]), exterior),
        Points(ids(points), np.array([draw(st.sampled_from(ROLES)) for _ in range(points)]), coordinates, sigma),
        ImageObservations(
            np.repeat(np.arange(images), points),
            np.tile(np.arange(points), images),
            table(any_float, images * points, 2),
            table(positive, images * points, 2),
        ),
    )


@settings(deadline=None)
@given(blocks())
def test_any_block_comes_back_bit_by_bit(block: Block) -> None:
    with TemporaryDirectory() as folder:
        write_block(block, folder)
        assert_same(read_block(folder), block)


@pytest.mark.parametrize(
    "name", ["a,b", 'say "hi"', '=HYPERLINK("x")', "=1+1", "ümlaut", "two\nlines", "a;b", "'", "\ufeff"]
)
def test_awkward_names_come_back(folder: Path, name: str) -> None:
    block = read_block(folder)
    points = Points((name, "2", "3"), block.points.role, block.points.coordinates, block.points.sigma)
    named = Block(block.cameras, block.images, points, block.observations)
    write_block(named, folder)
    assert_same(read_block(folder), named)


@pytest.mark.skipif(not SXB.is_dir(), reason="the SXB test data are not here (SIMFIELD_SXB)")
def test_a_real_block_is_read_and_comes_back(tmp_path: Path) -> None:
    block = read_block(SXB)
    assert (len(block.images), len(block.points), len(block.observations)) == (5, 381, 1196)
    assert np.unique(block.points.role, return_counts=True)[1].tolist() == [2, 14, 365]
    write_block(block, tmp_path)
    assert_same(read_block(tmp_path), block)
    for name in FILES:
        assert (tmp_path / name).read_text().splitlines() == (SXB / name).read_text().splitlines()


@pytest.mark.parametrize(
    "change",
    [
        lambda data: b"\xef\xbb\xbf" + data,
        lambda data: data.replace(b"\n", b"\r\n"),
        lambda data: data.replace(b"\n", b"\r"),
        lambda data: data.replace(b"\n", b"\n\n"),
        lambda data: data.rstrip(b"\n"),
    ],
    ids=["byte-order mark", "CRLF", "CR", "empty lines", "no last newline"],
)
def test_harmless_differences_of_form_are_accepted(folder: Path, change: Callable[[bytes], bytes]) -> None:
    block = read_block(folder)
    for name in FILES:
        (folder / name).write_bytes(change((folder / name).read_bytes()))
    assert_same(read_block(folder), block)


def test_columns_may_stand_in_any_order(folder: Path) -> None:
    (folder / "cameras.csv").write_text("height_mm,width_mm,y0_mm,x0_mm,c_mm,camera_id\n230,229,-0.02,0.01,153,ww\n")
    assert read_block(folder).cameras == (Camera("ww", 153.0, 0.01, -0.02, 229.0, 230.0),)


# Refusals


@pytest.mark.parametrize(
    ("file", "old", "new", "row", "column", "reason"),
    [
        ("points.csv", "role", "rol", 1, "rol", "unknown column 'rol', did you mean role?"),
        ("images.csv", "X0_m", "x0_M", 1, "x0_M", "did you mean X0_m?"),
        ("images.csv", "image_id", "bild", 1, "bild", "known are image_id, camera_id"),
        ("cameras.csv", ",height_mm", "", 1, "height_mm", "is missing, the header must have camera_id,c_mm"),
        ("cameras.csv", "height_mm", "width_mm", 1, "width_mm", "stands twice in the header"),
        ("observations.csv", "point_id,x", '"point\n_id",x', 1, None, r"unknown column 'point\n_id'"),
        ("images.csv", "\nb,ww", "\na,ww", 3, "image_id", "'a' stands already in row 2"),
        ("points.csv", "\n3,tie", "\n1,tie", 4, "point_id", "'1' stands already in row 2"),
        ("points.csv", "\n3,tie", "\n ,tie", 4, "point_id", "' ' is not an id"),
        ("points.csv", "\n3,tie", "\n,tie", 4, "point_id", "'' is not an id"),
        ("points.csv", "\n3,tie", "\n3 ,tie", 4, "point_id", "'3 ' is not an id"),
        ("images.csv", "b,ww", "b,sww", 3, "camera_id", "'sww' is not in cameras.csv"),
        ("observations.csv", "b,2,", "c,2,", 6, "image_id", "'c' is not in images.csv"),
        ("observations.csv", "b,2,", "b,7,", 6, "point_id", "'7' is not in points.csv"),
        ("observations.csv", "b,2,", "b,1,", 6, "point_id", "point '1' was already measured in image 'b'"),
        ("observations.csv", "3.0,4.0", "x,4.0", 3, "x_mm", "'x' is not a number"),
        ("observations.csv", "3.0,4.0", ",4.0", 3, "x_mm", "is empty, a number is needed"),
        ("observations.csv", "3.0,4.0", "3.0,nan", 3, "y_mm", "'nan' is not allowed, leave an unknown value empty"),
        ("observations.csv", "3.0,4.0", "3.0,-inf", 3, "y_mm", "'-inf' is not allowed, must be finite"),
        ("observations.csv", "3.0,4.0", "3.0,1e999", 3, "y_mm", "'1e999' is not allowed, must be finite"),
        ("observations.csv", "3.0,4.0", '"3,25",4.0', 3, "x_mm", "'3,25' has a decimal comma, write a decimal point"),
        ("observations.csv", "3.0,4.0", "3,25,4,0", 3, None, "has 8 field(s), the header has 6; write decimal points"),
        ("observations.csv", "3.0,4.0", "3_0,4.0", 3, "x_mm", "'3_0' is not a number of the digits 0-9"),
        ("observations.csv", "3.0,4.0", "٣,4.0", 3, "x_mm", "is not a number of the digits 0-9"),
        ("observations.csv", "3.0,4.0,0.005", "3.0,4.0,0", 3, "sigma_x_mm", "0 is not allowed, must be finite and > 0"),
        ("observations.csv", "3.0,4.0,0.005", "3.0,4.0,-1", 3, "sigma_x_mm", "-1 is not allowed"),
        ("observations.csv", "3.0,4.0,0.005", "3.0,4.0,", 3, "sigma_x_mm", "is empty, a number is needed"),
        ("observations.csv", "a,2,3.0", "a,3.0", 3, None, "has 5 field(s), the header has 6"),
        ("observations.csv", "a,2,3.0", "a,2,3.0,3.0", 3, None, "has 7 field(s), the header has 6"),
        ("points.csv", "3,tie", "3,Tie", 4, "role", "'Tie' is no role, allowed are control, check, tie"),
        ("points.csv", "0.0,0.01", "0.0,-0.01", 2, "sigma_Y_m", "-0.01 is not allowed, must be >= 0 or empty"),
        ("points.csv", "1.0,2.0,3.0", "1.0,,3.0", 2, "Y_m", "a control coordinate with a sigma needs a value"),
        ("points.csv", "4.0,5.0,6.0", "4.0,5.0,inf", 3, "Z_m", "'inf' is not allowed"),
        ("images.csv", "10.5,", ",", 2, "X0_m", "give all six or none"),
        ("images.csv", ",90.0", ",", 2, "kappa_deg", "give all six or none"),
        ("images.csv", ",90.0", ",9000.0", 2, "kappa_deg", "9000 is not allowed, |angle| <= 720 degrees"),
        ("images.csv", ",90.0", ",90°", 2, "kappa_deg", "'90°' is not a number"),
        ("cameras.csv", "153.0", "-153.0", 2, "c_mm", "-153 is not allowed, must be > 0"),
        ("cameras.csv", "153.0", "", 2, "c_mm", "is empty, a number is needed"),
        ("points.csv", "2,check", '"2,check', 3, None, "is not CSV"),
        ("points.csv", "2,check", '"2"x,check', 3, None, "is not CSV"),
    ],
)
def test_a_defect_is_named_with_file_row_and_column(
    folder: Path, file: str, old: str, new: str, row: int, column: str | None, reason: str
) -> None:
    text = FILES[file]
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    error = refusal(folder)
    assert (error.file, error.row, error.column) == (folder / file, row, column)
    assert reason in error.reason
    place = f"{folder / file}, row {row}" + (f", column {column}" if column else "")
    assert str(error) == f"{place}: {error.reason}"


@pytest.mark.parametrize(("separator", "word"), [(";", "semicolons"), ("\t", "tabs"), ("|", "bars")])
def test_another_separator_is_named(folder: Path, separator: str, word: str) -> None:
    text = FILES["observations.csv"]
    (folder / "observations.csv").write_text(text.replace(",", separator))
    assert str(refusal(folder)).endswith(f"observations.csv, row 1: is separated by {word}, only commas are allowed")
    header, rows = text.split("\n", 1)
    for decimal in (".", ","):
        body = rows.replace(",", separator).replace(".", decimal)
        (folder / "observations.csv").write_text(f"{header}\n{body}")
        error = refusal(folder)
        assert error.row == 2
        assert f"it is separated by {word}, only commas are allowed" in error.reason


def test_a_tie_point_with_one_ray_is_named_where_it_stands(folder: Path) -> None:
    (folder / "observations.csv").write_text(FILES["observations.csv"].replace("b,3,-5.0,-6.0,0.005,0.005\n", ""))
    place = f"{folder / 'points.csv'}, row 4, column point_id"
    assert str(refusal(folder)) == f"{place}: tie point '3' has 1 ray(s), at least two are needed"


def test_rows_are_counted_as_an_editor_counts_lines(folder: Path) -> None:
    text = FILES["points.csv"].replace("1,control", '"two\nlines",control').replace("3,tie", "\n3,Tie")
    (folder / "points.csv").write_text(text)
    assert refusal(folder).row == text.split("\n").index("3,Tie,,,,,,") + 1 == 6


def test_a_missing_folder_a_file_in_its_place_and_a_missing_file_are_named(folder: Path) -> None:
    assert str(refusal(folder / "nothing")).startswith(f"{folder / 'nothing'}: does not exist, needed is a folder")
    assert "is not a folder" in str(refusal(folder / "cameras.csv"))
    (folder / "points.csv").unlink()
    reason = "is missing, needed is a CSV file with the header point_id,role,"
    assert str(refusal(folder)).startswith(f"{folder / 'points.csv'}: {reason}")
    (folder / "points.csv").mkdir()
    assert str(refusal(folder)) == f"{folder / 'points.csv'}: is not a regular file"


def test_a_pipe_is_not_waited_for(folder: Path) -> None:
    (folder / "points.csv").unlink()
    os.mkfifo(folder / "points.csv")
    assert refusal(folder).reason == "is not a regular file"


def test_a_file_that_may_not_be_read_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(path: Path) -> bytes:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr(Path, "read_bytes", denied)
    assert str(refusal(folder)) == f"{folder / 'cameras.csv'}: cannot be read: Permission denied"


@pytest.mark.parametrize(
    ("data", "row", "reason"),
    [
        (b"", None, "is empty, the first line must be point_id,role,X_m"),
        (b"\n\n", None, "is empty"),
        (b"\xef\xbb\xbf", None, "is empty"),
        (FILES["points.csv"].split("\n")[0].encode(), None, "has a header but no rows"),
        (FILES["points.csv"].replace("3,tie", "ü,tie").encode("latin-1"), 4, "byte 0xfc is not UTF-8"),
        (FILES["points.csv"].encode("utf-16"), 1, "is encoded in UTF-16, only UTF-8 is allowed"),
        (FILES["points.csv"].replace("3,tie", "\0,tie").encode(), 4, "has a NUL byte"),
        (b"\x7fELF\x02\x01\x01\0\0", 1, "has a NUL byte"),
        (b"\x89PNG\r\n\x1a\n", 1, "byte 0x89 is not UTF-8"),
    ],
    ids=["empty", "empty lines", "only a mark", "only a header", "latin-1", "utf-16", "NUL", "program", "picture"],
)
def test_what_is_no_table_in_utf8_is_refused(folder: Path, data: bytes, row: int | None, reason: str) -> None:
    (folder / "points.csv").write_bytes(data)
    error = refusal(folder)
    assert (error.file.name, error.row, error.column) == ("points.csv", row, None)
    assert error.reason.startswith(reason)


@pytest.mark.parametrize(
    "text",
    [
        "point_id" + ",role" * 10_000_000,
        FILES["points.csv"] + "9" + "," * 10_000_000,
        "point_id," + "x" * 900_000,
        FILES["points.csv"] + "9," + "x" * 900_000,
        FILES["points.csv"] + '"' + "x\n" * 5_000_000,
        FILES["points.csv"].replace("3,tie", "3," + "x" * 100_000),
        FILES["points.csv"].replace("4.0,", "1" * 100_000 + ","),
        ",".join(f"c{i}" for i in range(100_000)),
    ],
    ids=["wide header", "wide row", "long name", "long field", "open quote", "long role", "long number", "many names"],
)
def test_a_bomb_is_refused_in_one_short_line_and_bounded_time(folder: Path, text: str) -> None:
    (folder / "points.csv").write_text(text)
    start = time.monotonic()
    assert len(str(refusal(folder))) < 1000
    assert time.monotonic() - start < SECONDS_FOR_A_BOMB


# Writing
