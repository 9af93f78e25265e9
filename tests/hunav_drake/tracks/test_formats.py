"""Files of recorded people: each format is read, written, and checked."""

import contextlib
import json
import os
from pathlib import Path
import sqlite3

import numpy as np
import pytest

from hunav_drake import ReadTracks, Tracks, WriteTracks
from hunav_drake.commands.cli import main
from hunav_drake.systems.people.tracks import Track
from hunav_drake.tracks.formats import FORMATS

REFERENCE = Path(
    os.environ.get("HUNAV_REFERENCE", "../shared/reference")
).resolve()
# From pixels to meters: a camera that looks down askew.
H = [[0.02, 0.001, 3.0], [-0.002, 0.03, 5.0], [1e-5, 2e-5, 1.0]]


def three_people():
    """People who come and go, every 0.4 s, with headings."""
    rng = np.random.default_rng(0)
    people = []
    for id, first, rows in ((2, 0, 8), (5, 3, 4), (11, 7, 6)):
        times = (first + np.arange(rows)) * 0.4
        places = np.cumsum(rng.normal(0.4, 0.1, (rows, 2)), axis=0)
        people.append(Track(id, times, places, rng.uniform(-3, 3, rows)))
    square = np.array([[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]], dtype=float)
    return Tracks(tuple(people), (square,))


def file_of(tmp_path, text, name="a.txt"):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", FORMATS)
def test_each_format_comes_back(name, tmp_path):
    expected = three_people()
    path = tmp_path / f"tracks{FORMATS[name].ending}"
    options = {"homography": H} if name == "ucy_vsp" else {}
    WriteTracks(expected, path, name, **options)
    # Its content tells the format.
    found = ReadTracks(path, **options)
    # (The persons of UCY's splines have no numbers.)
    ids = [1, 2, 3] if name == "ucy_vsp" else [2, 5, 11]
    assert [it.id for it in found.people] == ids
    for one, other in zip(found.people, expected.people, strict=True):
        assert np.allclose(one.times, other.times, atol=1e-9)
        assert np.allclose(one.positions, other.positions, atol=1e-9)
        if name == "csv":
            assert np.array_equal(one.yaws, other.yaws)
    if name == "jupedsim":
        assert np.array_equal(found.walls[0], expected.walls[0])


@pytest.mark.parametrize("name", ["petrack", "jupedsim", "trajnet"])
def test_formats_with_a_rate_hold_any_period(name, tmp_path):
    expected = three_people().resampled(0.0625)
    WriteTracks(expected, tmp_path / "a", name)
    found = ReadTracks(tmp_path / "a", name)
    assert found.period == 0.0625
    assert np.allclose(found.people[1].positions, expected.people[1].positions)


@pytest.mark.parametrize("name", ["petrack", "jupedsim", "trajnet"])
@pytest.mark.parametrize("fps", [15, 21, 24, 27, 29.97, 30, 37, 120])
@pytest.mark.parametrize("digits", [6, 15])
def test_rates_of_films_are_written_as_they_are(name, fps, digits, tmp_path):
    times = np.round(np.arange(500) / fps, digits)
    places = np.column_stack([times, np.zeros(500)])
    WriteTracks(Tracks((Track(1, times, places),)), tmp_path / "a", name)
    (found,) = ReadTracks(tmp_path / "a", name).people
    assert np.allclose(found.times, times, atol=1e-6)
    if name == "petrack" and digits == 15:
        assert f"framerate: {float(fps)}\n" in (tmp_path / "a").read_text()


def test_noise_of_stamps_is_no_other_rate(tmp_path):
    stamps = 1.7e9 + np.arange(3000) / 25
    times = stamps - stamps[0]
    assert (np.diff(times) != 0.04).any()
    tracks = Tracks((Track(1, times, np.zeros((3000, 2))),))
    assert tracks.period == 0.04
    WriteTracks(tracks, tmp_path / "a", "petrack")
    assert "framerate: 25.0\n" in (tmp_path / "a").read_text()


def test_formats_without_a_rate_need_their_own_period(tmp_path):
    tracks = three_people().resampled(0.1)
    for name in ("eth", "ucy"):
        with pytest.raises(ValueError, match=r"resample the tracks at 0\.4 s"):
            WriteTracks(tracks, tmp_path / "a.txt", name)
    assert not list(tmp_path.iterdir())


def test_formats_without_a_rate_refuse_every_other_row(tmp_path):
    tracks = three_people().resampled(0.8)
    for name in ("eth", "ucy"):
        with pytest.raises(ValueError, match=r"0\.8 s apart.* at 0\.4 s"):
            WriteTracks(tracks, tmp_path / "a.txt", name)


@pytest.mark.parametrize("name", ["petrack", "jupedsim", "trajnet"])
def test_rows_may_skip_frames(name, tmp_path):
    expected = three_people()
    WriteTracks(expected, tmp_path / "a", name, fps=10)
    found = ReadTracks(tmp_path / "a", name)
    for one, other in zip(found.people, expected.people, strict=True):
        assert np.allclose(one.times, other.times, atol=1e-9)


def test_one_row_has_no_rate(tmp_path):
    one = Tracks((Track(1, np.array([2.0]), np.zeros((1, 2))),))
    for name in ("petrack", "jupedsim", "trajnet"):
        with pytest.raises(ValueError, match="no rate; give fps"):
            WriteTracks(one, tmp_path / "a", name)
        WriteTracks(one, tmp_path / "a", name, fps=2.0)
        assert ReadTracks(tmp_path / "a", name, fps=2.0).people[0].times == [2]


def test_places_are_limited_in_meters_whatever_the_unit(tmp_path):
    path = file_of(tmp_path, "time,id,x,y\n0,1,2e7,0\n0.4,1,2e7,500\n")
    (it,) = ReadTracks(path, unit="mm").people
    assert it.positions.tolist() == [[20000.0, 0.0], [20000.0, 0.5]]
    with pytest.raises(ValueError, match=r"within 1e\+07 m of the origin"):
        ReadTracks(path)


def test_a_rate_counts_or_is_refused(tmp_path, capsys):
    path, out = tmp_path / "a.csv", tmp_path / "b.txt"
    WriteTracks(three_people(), path)
    with pytest.raises(ValueError, match="fps has no part in csv"):
        ReadTracks(path, fps=30)
    words = ["tracks", str(path), "--fps", "5"]
    assert main(words) == 2
    assert "leave it out" in capsys.readouterr().err
    assert main([*words, "-o", str(tmp_path / "b.csv")]) == 2
    assert main([*words, "-o", str(out), "--as", "petrack"]) == 0
    assert "framerate: 5.0" in out.read_text()


def test_areas_of_several_parts_in_a_collection_are_walls(tmp_path):
    path = tmp_path / "a.sqlite"
    WriteTracks(three_people(), path, "jupedsim")
    area = "((0 0, 9 0, 9 9, 0 0), (3 1, 4 1, 4 2, 3 1))"
    other = "((20 0, 29 0, 29 9, 20 0))"
    with contextlib.closing(sqlite3.connect(path)) as database:
        database.execute(
            "UPDATE geometry SET wkt = ?",
            [f"GEOMETRYCOLLECTION (MULTIPOLYGON ({area}, {other}))"],
        )
        database.commit()
    found = ReadTracks(path).walls
    assert [it[0].tolist() for it in found] == [[0, 0], [3, 1], [20, 0]]


def test_places_on_maps_are_read_and_can_be_shifted(tmp_path):
    rows = "0,1,4.54e5,5.412e6\n0.4,1,4.54e5,5412000.5\n"
    path = file_of(tmp_path, "time,id,x,y\n" + rows)
    out = tmp_path / "b.csv"
    words = ["tracks", str(path), "--shift", "-454000", "-5412000"]
    assert main([*words, "-o", str(out)]) == 0
    (it,) = ReadTracks(out).people
    assert it.positions.tolist() == [[0.0, 0.0], [0.0, 0.5]]


def test_juelich_text_has_rate_and_unit_in_its_header(tmp_path):
    rows = "1\t10\t100.0\t50.0\t160\n1\t11\t108.0\t50.0\t160\n"
    header = "\ufeff# PeTrack project: a\n# framerate: 16 fps\n"
    path = file_of(tmp_path, f"{header}# id frame x/cm y/cm z/cm\n{rows}")
    (it,) = ReadTracks(path).people
    assert it.times.tolist() == [10 / 16, 11 / 16]
    assert np.allclose(it.positions, [[1.0, 0.5], [1.08, 0.5]])
    bare = file_of(tmp_path, rows)
    with pytest.raises(ValueError, match=r"names no frame rate.*give fps"):
        ReadTracks(bare)
    with pytest.raises(ValueError, match=r"names no unit.*give unit"):
        ReadTracks(bare, fps=16)
    (same,) = ReadTracks(bare, fps=16, unit="cm").people
    assert np.allclose(same.positions, it.positions)


def test_trajnet_counts_rows_per_second_and_has_predictions(tmp_path):
    lines = [
        {"scene": {"id": 0, "p": 1, "s": 0, "e": 20, "fps": 2.5}},
        *(
            {"track": {"f": f, "p": 1, "x": 0.1 * f, "y": 0.0}}
            for f in (0, 10, 20)
        ),
        {
            "track": {
                **{"f": 20, "p": 1, "x": 9.0, "y": 9.0},
                "prediction_number": 0,
            }
        },
    ]
    path = file_of(tmp_path, "\n".join(map(json.dumps, lines)))
    (it,) = ReadTracks(path).people
    assert np.allclose(it.times, [0, 0.4, 0.8])
    assert np.allclose(it.positions[:, 0], [0, 1, 2])


def test_pixels_need_a_homography(tmp_path):
    text = (
        "1 - the number of splines\n2 - Num of control points\n"
        "10.0 20.0 0 90.0 - (2D point, m_id)\n"
        "12.0 20.0 25 90.0 - (2D point, m_id)\n"
        "0 - the number of gaze points\n"
    )
    path = file_of(tmp_path, text, "a.vsp")
    with pytest.raises(ValueError, match="pixels of a film; give homography"):
        ReadTracks(path)
    (it,) = ReadTracks(path, homography=H).people
    assert it.times.tolist() == [0.0, 1.0]
    expected = np.array(H) @ [10, 20, 1]
    assert np.allclose(it.positions[0], expected[:2] / expected[2])
    with pytest.raises(ValueError, match="3 x 3 finite numbers"):
        ReadTracks(path, homography=np.zeros((3, 3)))
    # Meters need none.
    words = "homography is for pixels, as of ucy_vsp; csv has meters"
    with pytest.raises(ValueError, match=words):
        WriteTracks(three_people(), tmp_path / "b.csv", homography=H)
    WriteTracks(three_people(), tmp_path / "b.csv")
    with pytest.raises(ValueError, match=words):
        ReadTracks(tmp_path / "b.csv", homography=H)


def damaged_cases():
    """Texts with a fault, their format, and what is told of it."""
    ucy = "0 1 0 0\n10 1 1 0\n"
    yield "ucy", ucy + "20 1 a 0\n", r"row 3: must be 4 numbers.*delete it"
    yield "ucy", ucy + "20 1\n", r"row 3: must be 4 numbers \(frame, person"
    yield "ucy", ucy + "10 1 5 5\n", r"row 3: person 1 is at 0\.4 s in row 2"
    yield "ucy", ucy + "20 1 nan 0\n", "row 3: the position must be within"
    yield "ucy", ucy + "20 1.5 1 0\n", "row 3: the person must be a whole"
    yield "ucy", ucy + "20 inf 1 0\n", "row 3: the person must be a whole"
    yield "ucy", ucy + "20 1e30 1 0\n", "row 3: the person must be a whole"
    yield "ucy", ucy + "1e300 1 1 0\n", "row 3: the time must be a number"
    yield "ucy", "", "has no rows"
    yield "auto", "", "has no rows"
    yield (
        "petrack",
        "# framerate: 0\n# x/m\n1 0 0 0\n",
        "has the frame rate '0'",
    )
    yield "petrack", "# framerate: 1.2.3\n# x/m\n1 0 0 0\n", "'1.2.3', which"
    yield "eth", "0 1 0 0\n", "row 1: must be 8 numbers"
    yield "csv", "time,id,x\n", "row 1: must name the columns time, id, x, y"
    yield "csv", "time,id,x,y\n0,1,2\n", "row 2: must be 4 numbers"
    yield "trajnet", '{"track": {"f": 0}}\n', "row 1: must be .*track"
    yield "trajnet", "{]\n", "row 1: must be"
    yield "trajnet", '"track"\n', "row 1: must be"
    yield "jupedsim", "SQLite format 3", "not a database of JuPedSim"
    yield (
        "ucy_vsp",
        "1 - the number of splines\n3 - Num of control points\n1 2 3 4\n",
        "ends before the last 2 control points of person 1",
    )
    yield "petrack", "# framerate: 25\n# x/m\n1 0 0\n", "row 3: must be 4"


@pytest.mark.parametrize(("name", "text", "told"), [*damaged_cases()])
def test_damaged_files_get_one_line(name, text, told, tmp_path):
    path = file_of(tmp_path, text)
    with pytest.raises(ValueError, match=told) as caught:
        ReadTracks(path, name, homography=H if name == "ucy_vsp" else None)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(path))


def test_a_database_without_a_table_is_told(tmp_path):
    path = tmp_path / "a.sqlite"
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE metadata(key, value)")
    with pytest.raises(ValueError, match="no such table"):
        ReadTracks(path)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"format": "etc"}, "format: there is no 'etc'; did you mean 'eth'"),
        ({"fps": 0.0}, "fps: must be a number"),
        ({"fps": float("nan")}, "fps: must be a number"),
        ({"unit": "km"}, "unit: must be m, cm or mm"),
    ],
)
def test_wrong_options_are_told(options, told, tmp_path):
    with pytest.raises(ValueError, match=told):
        ReadTracks(file_of(tmp_path, "0 1 0 0\n"), **options)


def test_what_is_no_recording_is_told(tmp_path):
    with pytest.raises(ValueError, match="is of no known format"):
        ReadTracks(file_of(tmp_path, "Dear reader\n"))


@pytest.mark.parametrize(
    ("name", "people", "speed"),
    [("eth", 360, 2.45), ("zara01", 148, 1.15), ("students003", 434, 0.79)],
)
def test_recorded_streets(name, people, speed):
    path = REFERENCE / "tracks" / f"{name}.txt"
    if not path.exists():
        pytest.skip("the recorded people are not here")
    tracks = ReadTracks(path)
    assert len(tracks.people) == people
    assert tracks.period == 0.4
    from hunav_drake.tracks.facts import describe_tracks

    assert describe_tracks(tracks).speeds[1] == pytest.approx(speed, abs=0.1)


def test_the_command_tells_draws_and_converts(tmp_path, capsys):
    source = tmp_path / "a.txt"
    WriteTracks(three_people(), source, "ucy")
    out, plot = tmp_path / "b.csv", tmp_path / "b.png"
    words = ["tracks", str(source), "--period", "0.1", "--rotate", "90"]
    words += ["-o", str(out), "--plot", str(plot)]
    assert main(words) == 0
    told = capsys.readouterr().out
    assert "people          3\n" in told
    assert f"Wrote {out}" in told
    assert plot.read_bytes().startswith(b"\x89PNG")
    found = ReadTracks(out)
    assert found.period == 0.1
    assert np.allclose(
        found.people[0].positions[0],
        three_people().people[0].positions[0] @ [[0, 1], [-1, 0]],
    )
    # Nothing is overwritten.
    assert main(words) == 2
    assert "--force" in capsys.readouterr().err
    assert main(["tracks", str(source), "--from", "100"]) == 2
    assert "nobody is there" in capsys.readouterr().err
    assert main(["tracks", str(source), "--plot", "a.bmp"]) == 2


def test_what_means_nothing_for_a_file_is_refused(tmp_path, capsys):
    source, matrix = tmp_path / "a.txt", tmp_path / "H.txt"
    WriteTracks(three_people(), source, "ucy")
    matrix.write_text("1 0 0\n0 1 0\n0 0 1\n")
    for more, words in (
        (["--homography", str(matrix)], "is for pixels, as of ucy_vsp"),
        (["--period", "1e-9"], "period: must be at least 0.001 s"),
    ):
        assert main(["tracks", str(source), *more]) == 2
        assert words in capsys.readouterr().err
    for words in (
        ["validate", "--workers", "2", "--tracks", str(source)],
        ["validate", "--tracks", str(source), str(source)],
        ["fit", str(source), "--holdout", str(source)],
    ):
        assert main(words) == 2
        told = capsys.readouterr().err
        assert "--workers: has no effect" in told or "named twice" in told


def test_an_end_alone_keeps_what_is_before_zero(tmp_path, capsys):
    source = tmp_path / "early.csv"
    rows = [f"{0.1 * k:.1f},1,{0.1 * k:.2f},0" for k in range(-20, 21)]
    source.write_text("time,id,x,y\n" + "\n".join(rows) + "\n")
    assert main(["tracks", str(source), "--to", "1"]) == 0
    assert "-2.0 to 1.0 s" in capsys.readouterr().out
    assert main(["tracks", str(source), "--to", "-5"]) == 2
    assert "nobody is there until -5 s" in capsys.readouterr().err
