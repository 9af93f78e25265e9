"""Recordings of the robot and a person as other programs write them."""


def table_rows(recording, person=0) -> list[list[str]]:
    """Returns a recording as a table with a row per body."""
    rows = [["time", "agent", "x", "y", "yaw", "vx", "vy", "omega", "radius"]]
    for k, time in enumerate(recording.times):
        bodies = {
            "robot": recording.robot[k],
            "ana": recording.humans[k, person],
        }
        for name, state in bodies.items():
            rows.append([repr(float(time)), name, *map(repr, state.tolist())])
    return rows


def hunavsim_messages(recording, person=0) -> dict[str, object]:
    """Returns a recording as the messages that HuNavSim's evaluator gets."""
    keys = ("x", "y", "yaw", "vx", "vy", "angular_vel", "radius")

    def body(state):
        values = dict(zip(keys, state.tolist(), strict=True))
        return values | {"linear_vel": 0.5, "closest_obs": [[1.0, 2.0]]}

    steps = [
        {
            "sec": int(time),
            "nanosec": round(time % 1 * 1e9),
            "robot": body(recording.robot[k]),
            "agents": [body(recording.humans[k, person]) | {"id": 1}],
        }
        for k, time in enumerate(recording.times.tolist())
    ]
    return {"robot_goal": [1.0, 2.0], "robot_goal_radius": 0.3, "steps": steps}
