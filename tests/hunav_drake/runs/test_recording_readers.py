import contextlib
import copy
import dataclasses
import gzip
import json
import math
import re

import numpy as np
import pytest

from hunav_drake.commands.cli import main
from hunav_drake.runs.recording_files import ReadRecording
from hunav_drake.systems.evaluation.compute import (
    compute_metrics,
    compute_steps,
)
from hunav_drake.systems.evaluation.recording import Recording

CSV = """\
time,agent,x,y,yaw,vx,vy,omega,radius,behavior,group_id,behavior_status
0.0,robot,0,0,0,1,0,0,0.3,,-1,0
0.0,ana,3,1,3.1,-1,0,0.1,0.25,scared,2,0
0.5,ana,2.5,1,3.1,-1,0,0.1,0.25,scared,2,1
0.5,robot,0.5,0,0,1,0,0,0.3,,-1,0
0.5,Bo Ø,9,9,0,0,0,0,0.4,regular,2,0
"""


def agent(**kwargs):
    state = {
        "x": 0.0,
        "y": 0.0,
        "yaw": 0.0,
        "vx": 0.0,
        "vy": 0.0,
        "linear_vel": 0.0,
        "angular_vel": 0.0,
        "radius": 0.35,
    }
    return state | kwargs


def recorded_step(k, **kwargs):
    return {
        "sec": k,
        "nanosec": 500_000_000,
        "robot": agent(x=1.0 * k, linear_vel=1.0),
        "agents": [
            agent(
                id=7,
                x=5.0,
                vx=-3.0,
                vy=4.0,
                linear_vel=5.0,
                behavior=4,
                behavior_state=1,
                group_id=2,
                closest_obs=[[1.0, 2.0, 0.0]],
            )
        ],
    } | kwargs


@pytest.fixture
def write(tmp_path):
    def write(name, content):
        path = tmp_path / name
        if not isinstance(content, bytes):
            text = content if isinstance(content, str) else json.dumps(content)
            content = text.encode()
        path.write_bytes(content)
        return path

    return write


def test_a_saved_recording_comes_back(tmp_path):
    recording = Recording(
        times=[0.0, 1.0], robot=np.ones((2, 7)), humans=np.ones((2, 1, 7))
    )
    recording.save(tmp_path / "a.npz")
    assert ReadRecording(tmp_path / "a.npz") == recording
    assert ReadRecording(str(tmp_path / "a.npz")) == recording


def test_a_whole_table(write):
    dut = ReadRecording(write("a.csv", CSV))
    assert dut.times.tolist() == [0.0, 0.5]
    assert dut.robot[1].tolist() == [0.5, 0, 0, 1, 0, 0, 0.3]
    assert dut.human_names == ("ana", "Bo Ø")
    assert dut.behaviors == ("scared", "regular")
    assert dut.group_ids == (2, 2)
    assert dut.humans[1, 0].tolist() == [2.5, 1, 3.1, -1, 0, 0.1, 0.25]
    assert np.isnan(dut.humans[0, 1]).all()
    assert dut.behavior_status.tolist() == [[0, 0], [1, 0]]


def test_the_order_of_rows_does_not_matter(write):
    header, *lines = CSV.splitlines()
    other = "\n".join([header, *lines[::-1]])
    a, b = (
        ReadRecording(write("a.csv", CSV)),
        ReadRecording(write("b.csv", other)),
    )
    order = [b.human_names.index(name) for name in a.human_names]
    assert np.array_equal(a.humans, b.humans[:, order], equal_nan=True)
    assert np.array_equal(a.robot, b.robot)


def test_what_positions_tell_is_worked_out(write):
    lines = ["time,agent,x,y"]
    for k in range(41):
        t = 0.1 * k
        lines.append(f"{t},robot,{math.cos(t)},{math.sin(t)}")
        lines.append(f"{t},ana,2,{max(0, t - 2)}")
    dut = ReadRecording(write("a.csv", "\n".join(lines)))
    t = dut.times[1:-1]
    robot = dut.robot[1:-1]
    assert robot[:, 3] == pytest.approx(-np.sin(t), abs=0.01)
    assert robot[:, 4] == pytest.approx(np.cos(t), abs=0.01)
    assert np.unwrap(robot[:, 2]) == pytest.approx(t + math.pi / 2, abs=0.01)
    assert robot[2:-2, 5] == pytest.approx(1, abs=0.01)
    assert (dut.robot[:, 6] == 0.35).all()
    # At rest, the heading is that of the motion to come.
    assert dut.humans[:, 0, 2] == pytest.approx(np.full(41, math.pi / 2))
    assert compute_metrics(dut)["path_length"] == pytest.approx(4, rel=1e-3)


def test_who_comes_back_has_no_speed_from_being_away(write):
    text = "time,agent,x,y\n" + "".join(
        f"{k},robot,0,0\n" + (f"{k},ana,{10 * k},0\n" if k != 2 else "")
        for k in range(4)
    )
    dut = ReadRecording(write("a.csv", text))
    assert dut.humans[:, 0, 3].tolist() == pytest.approx(
        [10, 10, math.nan, 0], nan_ok=True
    )


@pytest.mark.parametrize("name", ["a.csv", "a.CSV", "a.csv.gz", "b.x.csv"])
def test_the_name_tells_the_kind(write, name):
    data = CSV.encode()
    path = write(
        name, gzip.compress(data, mtime=0) if name.endswith("gz") else data
    )
    assert len(ReadRecording(path)) == 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("agent", "name"), "line 1: the table has no column 'agent'"),
        (("omega", "omga"), "line 1: there is no column 'omga'; did you mean"),
        (("vy", "vx"), "line 1: there are two columns 'vx'"),
        (("3.1,-1", "east,-1"), "line 3: yaw must be a finite.*'east'"),
        (
            ("0.5,0,0", "nan,0,0"),
            "line 5: x must be a finite number, at most .* got 'nan'",
        ),
        (("0.25", "-0.25"), "line 3: radius must be .* not negative"),
        (("0.5,0,0", "1e11,0,0"), r"line 5: x .* at most 1e\+10 .*got '1e11'"),
        (("d,2,0", "d,2.5,0"), "line 3: group_id must be a whole number"),
        (("9,9,", "9,"), "line 6: has 11 cells, but the header has 12"),
        (("robot", "Robot"), "no row has the agent 'robot'"),
        (("0.5,robot", "0.0,robot"), "line 5: 'robot' has a row.*in line 2"),
        (("0.5,robot", "0.6,robot"), "'robot' has no row for 0.5 s"),
        (("Bo Ø", '"Bo'), "line 6"),
        (
            ("5,scared,2,1", "5,curious,2,1"),
            "line 4: the behavior of 'ana' must not change, but is curious"
            " here and scared in line 3",
        ),
        (
            ("scared,2,1", "scared,1,1"),
            "line 4: the group_id of 'ana' must not change, but is 1 here and"
            " 2 in line 3",
        ),
    ],
)
def test_a_fault_in_a_table_is_named_with_its_line(write, change, message):
    # Only the first of its kind, but of names all.
    count = -1 if change[0] == "robot" else 1
    path = write("a.csv", CSV.replace(*change, count))
    with pytest.raises(ValueError, match=rf"a\.csv: .*{message}"):
        ReadRecording(path)


def test_a_speed_worked_out_must_be_possible(write):
    rows = ["time,agent,x,y", "0,robot,0,0", "2e-6,robot,9e9,0"]
    with pytest.raises(
        ValueError, match=r"a\.csv: 'robot' at 0 s: vx, worked out .*4.5e\+15"
    ):
        ReadRecording(write("a.csv", "\n".join(rows)))


@pytest.mark.parametrize("text", ["", "\n", "time,agent,x,y\n"])
def test_an_empty_table_is_an_error(write, text):
    with pytest.raises(ValueError, match=r"a\.csv: .*(no rows|no column)"):
        ReadRecording(write("a.csv", text))


@pytest.mark.parametrize(
    "form",
    [
        lambda steps: steps,
        lambda steps: {"published": steps},
        lambda steps: {"steps": steps},
        lambda steps: {"input": {"steps": steps}},
    ],
)
def test_steps_of_messages(write, form):
    dut = ReadRecording(
        write("a.json", form([recorded_step(0), recorded_step(1)]))
    )
    assert dut.times.tolist() == [0.0, 1.0]
    assert dut.robot[1].tolist() == [1, 0, 0, 1, 0, 0, 0.35]
    assert dut.humans[0, 0, 3:5] == pytest.approx([-3, 4])
    assert dut.human_ids == (7,)
    assert dut.behaviors == ("scared",)
    assert dut.group_ids == (2,)
    assert dut.behavior_status.tolist() == [[1], [1]]
    assert dut.nearest_walls[0, 1].tolist() == [[1, 2]]
    assert np.isnan(dut.nearest_walls[0, 0]).all()
    assert dut.goal is None


def test_the_goal_may_stand_beside_the_steps(write):
    document = {
        "published": [recorded_step(0)],
        "expected": {"robot_goal": [3.0, 4.0], "robot_goal_radius": 0.2},
    }
    dut = ReadRecording(
        write("a.json.gz", gzip.compress(json.dumps(document).encode()))
    )
    assert dut.goal == (3, 4, 0)
    assert dut.goal_tolerance == 0.2


def test_the_heading_of_a_goal_counts(write):
    document = {"steps": [recorded_step(0)], "robot_goal": [0.0, 0.0, 3.0]}
    dut = ReadRecording(write("a.json", document))
    assert dut.goal == (0, 0, 3)
    assert dut.goal_yaw_tolerance == 0.25
    assert dut.goal_tolerance == 0.2
    assert compute_metrics(dut)["completed"] == 0
    document["robot_goal"] = [0.0, 0.0]
    dut = ReadRecording(write("a.json", document))
    assert dut.goal_yaw_tolerance == math.pi
    assert compute_metrics(dut)["completed"] == 1


def test_agents_may_come_and_go(write):
    steps = [recorded_step(0), recorded_step(1, agents=[]), recorded_step(2)]
    dut = ReadRecording(write("a.json", steps))
    assert np.isnan(dut.humans[:, 0, 0]).tolist() == [False, True, False]


def test_a_repeated_stamp_is_moved_on_by_a_hair(write):
    steps = [
        recorded_step(1),
        recorded_step(1),
        recorded_step(1),
        recorded_step(2),
    ]
    dut = ReadRecording(write("a.json", steps))
    assert dut.times == pytest.approx([0, 0, 0, 1], abs=1e-8)
    assert (np.diff(dut.times) > 0).all()


def test_a_robot_moves_where_its_velocity_says(write):
    """Not along its heading: in Gazebo, robots slip and drive backwards."""
    velocities = [(0.3, 0.4), (-0.5, 0.0), (0.0, 0.0)]
    steps = [
        recorded_step(k, robot=agent(yaw=1.0, vx=vx, vy=vy, linear_vel=0.5))
        for k, (vx, vy) in enumerate(velocities)
    ]
    dut = ReadRecording(write("a.json", steps))
    expected = [*velocities[:2], (0.5 * math.cos(1.0), 0.5 * math.sin(1.0))]
    np.testing.assert_allclose(dut.robot[:, 3:5], expected, atol=1e-12)


@pytest.mark.parametrize("key", ["yaw", "linear_vel"])
def test_forces_of_hunavsim_follow_from_velocities_alone(write, key):
    """Gazebo's robots slip, and its people tell no speed above the preferred.

    Neither their headings nor the speeds beside the velocities count.
    """

    def forces(value):
        steps = [
            recorded_step(k, robot=agent(x=4.0, vx=0.3, vy=0.4, linear_vel=0.5))
            for k in range(3)
        ]
        for step in steps:
            for body in (step["robot"], *step["agents"]):
                body[key] = value
        recording = ReadRecording(write("a.json", steps))
        recording = dataclasses.replace(recording, hunavsim_forces=True)
        recording = recording.with_stale_samples(2, 1.0).only("scared")
        file = write("a.npz", b"")
        recording.save(file)
        assert Recording.load(file) == recording
        return compute_metrics(recording, ["social_force_on_agents"]).iloc[0]

    assert forces(0.1) > 0
    assert forces(0.4) == forces(0.1)


def speeding_up(first, *, repeat=None):
    """Returns steps of 50 ms at 0.02 m/s^2; one may have the stamp before."""
    steps = []
    for k in range(40):
        nanoseconds = 50_000_000 * (k - 1 if k == repeat else k)
        v = 0.5 + 0.001 * k
        robot = agent(x=0.025 * k, vx=v, linear_vel=v)
        steps.append(
            {
                "sec": first + nanoseconds // 10**9,
                "nanosec": nanoseconds % 10**9,
                "robot": robot,
                "agents": [],
            }
        )
    return steps


@pytest.mark.parametrize("repeat", [None, 1, 20, 39])
def test_the_time_of_day_costs_no_precision(write, repeat):
    early, late = (
        ReadRecording(write("a.json", speeding_up(first, repeat=repeat)))
        for first in (0, 1_700_000_000)
    )
    assert early == late
    assert late.times[-2] == pytest.approx(38 * 0.05, rel=1e-12)


@pytest.mark.parametrize("repeat", [1, 20, 39])
def test_a_repeated_stamp_tells_nothing_of_accelerations(write, repeat):
    clean = ReadRecording(write("a.json", speeding_up(0)))
    dut = ReadRecording(write("b.json", speeding_up(0, repeat=repeat)))
    assert len(dut) == len(clean)
    expected = compute_metrics(clean)
    got = compute_metrics(dut)
    assert expected["avg_robot_acceleration"] == pytest.approx(0.02)
    # The interval after the repeated stamp is twice as long.
    steps = compute_steps(dut, ["avg_robot_acceleration"]).iloc[:, 0]
    assert math.isnan(steps.iloc[repeat])
    assert got["avg_robot_acceleration"] == pytest.approx(0.02, rel=0.02)
    assert got["avg_robot_jerk"] < 0.02
    for name in ("path_length", "avg_robot_linear_speed", "duration"):
        assert got[name] == pytest.approx(expected[name], rel=0.03)


def test_two_steps_at_one_time_have_no_acceleration(write):
    steps = [recorded_step(0), recorded_step(0, robot=agent(linear_vel=3.0))]
    values = compute_metrics(ReadRecording(write("a.json", steps)), ["speeds"])
    assert math.isnan(values["avg_robot_acceleration"])
    assert math.isnan(values["avg_robot_jerk"])


@pytest.mark.parametrize(("key", "value"), [("behavior", 5), ("group_id", 3)])
def test_who_a_person_is_does_not_change_in_messages(write, key, value):
    steps = [recorded_step(0), recorded_step(1), recorded_step(2)]
    steps[2]["agents"][0][key] = value
    with pytest.raises(
        ValueError,
        match=rf"steps\[2\]\.agents\[0\]\.{key}: must not change, but is"
        rf" {value} here and \d in steps\[0\]\.agents\[0\]",
    ):
        ReadRecording(write("a.json", steps))


def test_walls_are_not_known_unless_near_points_are(write):
    assert not ReadRecording(write("a.csv", CSV)).walls_known
    dut = ReadRecording(write("a.json", [recorded_step(0)]))
    assert not dut.walls_known
    assert dut.near_walls_known
    bare = recorded_step(0, agents=[agent(id=1, x=2.0)])
    dut = ReadRecording(write("a.json", [bare]))
    assert dut.nearest_walls is None
    assert not dut.near_walls_known


def test_clocks_that_differ_by_rounding_are_one(write):
    text = "time,agent,x,y\n" + "".join(
        f"{t},robot,{t},0\n{k / 10},ana,2,0\n"
        for k, t in enumerate((0, 0.1, 0.2, 0.30000000000000004))
    )
    dut = ReadRecording(write("a.csv", text))
    assert dut.times == pytest.approx([0, 0.1, 0.2, 0.3])
    assert not np.isnan(dut.humans).any()
    apart = text.replace("0.3,ana", "0.30001,ana")
    with pytest.raises(ValueError, match=r"'robot' has no row for 0\.30001 s"):
        ReadRecording(write("a.csv", apart))
    twice = text + "0.3000005,robot,9,9\n"
    with pytest.raises(ValueError, match=r"line 10: 'robot' has a row"):
        ReadRecording(write("a.csv", twice))


@pytest.mark.parametrize("separator", [";", "\t"])
def test_other_separators_are_found(write, separator):
    dut = ReadRecording(write("a.csv", CSV.replace(",", separator)))
    assert dut == ReadRecording(write("b.csv", CSV))


def broken(path, value):
    """Returns steps with one value changed, or taken away."""
    steps = [recorded_step(0), recorded_step(1)]
    at = steps
    for key in path[:-1]:
        at = at[key]
    if value is None:
        del at[path[-1]]
    else:
        at[path[-1]] = value
    return steps


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ((1, "sec"), None, r"steps\[1\]: has no 'sec'"),
        ((1, "sec"), -3, r"steps\[1\]: is at -2.5 s, after a step at 0.5 s"),
        ((1,), 5, r"steps\[1\]: must be an object, got 5"),
        ((0, "robot", "yaw"), None, r"steps\[0\]\.robot: has no 'yaw'"),
        ((0, "robot", "x"), "nan", r"robot\.x: must be a finite number.*nan"),
        ((0, "robot", "x"), True, r"robot\.x: must be a finite number.*True"),
        ((0, "agents"), {}, r"steps\[0\]\.agents: must be a list"),
        ((1, "agents", 0, "id"), None, r"steps\[1\]\.agents\[0\]: has no 'id'"),
        ((1, "agents", 0, "id"), "7", r"agents\[0\]\.id: must be a whole"),
        ((1, "agents", 0, "group_id"), 1.5, r"group_id: must be a whole"),
        (
            (1, "agents"),
            [agent(id=1), agent(id=1)],
            r"steps\[1\]\.agents\[1\]: the id 1 is taken",
        ),
        ((0, "agents", 0, "closest_obs"), [[1]], "needs 2 numbers"),
    ],
)
def test_a_fault_in_messages_is_named_with_its_place(
    write, path, value, message
):
    file = write("a.json", copy.deepcopy(broken(path, value)))
    with pytest.raises(ValueError, match=rf"a\.json: {'.*'}{message}"):
        ReadRecording(file)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.json", "{", "is not JSON"),
        ("a.json", "[" * 100_000, "is not JSON"),
        ("a.json", "3", "must be a list"),
        ("a.json", {"people": []}, "needs a list of steps, or one under"),
        ("a.json", [], "at least one step"),
        ("a.json.gz", b"abc", "cannot be unpacked"),
        (
            "a.json.gz",
            gzip.compress(b"[1, 2, 3]" * 99, mtime=0)[:-9],
            "be unpacked",
        ),
        ("a.csv", b"time,agent,x,y\n\xff", "not a text in UTF-8"),
        ("a.npz", b"abc", "is not a recording"),
        ("a.txt", "abc", r"must end in \.npz, \.csv"),
        ("a", "abc", "must end in"),
        ("a.npz.gz", "abc", "must end in"),
    ],
)
def test_a_wrong_file_is_one_clear_error(write, name, content, message):
    with pytest.raises(ValueError, match=message):
        ReadRecording(write(name, content))


def test_a_file_that_is_not_there_is_named(tmp_path):
    for name in ("a.csv", "a.json.gz", "a.npz"):
        with pytest.raises(FileNotFoundError, match=name):
            ReadRecording(tmp_path / name)


LONG = "x" * 100_000
HEAD = "time,agent,x,y"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", f"time,agent,x,{LONG}\n0,robot,0,0\n"),
        ("a.csv", f"{HEAD}\n{LONG},robot,0,0\n"),
        ("a.csv", f"{HEAD}\n0,{LONG},0,0\n0,{LONG},0,0\n"),
        ("a.csv", f"{HEAD}\n0,robot,0,0\n0,{LONG},0,0\n1,{LONG},9e9,0\n"),
        ("a.csv", f"{HEAD},behavior\n0,a,0,0,b\n1,a,0,0,{LONG}\n"),
        ("a.json", f'[{{"sec": "{LONG}", "nanosec": 0}}]'),
        ("a.json", f'[{{"sec": 0, "nanosec": 0, "{LONG}": 1}}]'),
        ("a.npz", LONG),
    ],
)
def test_long_values_are_cut_in_messages(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=re.escape(str(path))) as caught:
        ReadRecording(path)
    assert len(str(caught.value)) < 1000


def test_commands_cut_long_lines(tmp_path, capsys):
    path = tmp_path / "a.csv"
    path.write_text("time,agent,x,y\n0,robot,0,0\n")
    for words in (
        ["evaluate", str(path), "--metrics", LONG],
        ["evaluate", str(path), "--goal", LONG],
        ["run", LONG],
        ["run", "passing", "--planner", LONG],
        ["run", "passing", "--seed", LONG],
        [LONG],
    ):
        with contextlib.suppress(SystemExit):
            assert main(words) == 2
        told = capsys.readouterr().err
        assert told
        assert max(map(len, told.splitlines())) < 2100, words[:2]
