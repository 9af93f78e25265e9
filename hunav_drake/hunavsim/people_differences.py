"""What differs from how people move, decide and are served in HuNavSim."""

from hunav_drake.hunavsim.row import Difference

_KERNEL = "crowd: {model: {kernel: hunavsim}}"
_TREE = "humans[].behavior: "

_FORCES = (
    Difference(
        area="forces",
        name="theta near zero",
        original="the sign of theta decides to which side, however small it is",
        here="|theta| < 1e-12 has no side",
        why="at equal velocities theta is rounding, and the side would be, too",
        key=_KERNEL,
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="epsilon",
        original="calls the form of lightsfm that has none: people who meet"
        " exactly head-on have no side",
        here="0.005: they pass on the right",
        why="they would run into each other",
        key="humans[].forces: {epsilon: 0.0}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="people on one point",
        original="push each other if their velocities differ; if not, all"
        " social forces on them are zero",
        here="the force of the pair is zero, the others count",
        why="a limit that takes nothing from others",
        key=_KERNEL,
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="negligible forces",
        original="every pair is computed",
        here="from 48 people on, what adds up to less than 1e-6 m/s^2 for each"
        " is left out",
        why="most pairs are far apart, and it is faster",
        key="crowd: {model: {error_bound: 0.0}}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="several walls",
        original="its simulators tell people the nearest point of all, within"
        " 10 m",
        here="people feel the nearest point of each wall within 5 m",
        why="in a corner there are two walls",
        key="crowd: {obstacle_range: 10.0, max_obstacles: 1}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="ways around walls",
        original="people walk straight at their goals, and feel walls as hard"
        " in doors as anywhere",
        here="they walk around walls, and mind them less in narrow passages",
        why="they stay behind a wall else, and fit through no door",
        key="crowd: {route_planning: false}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="inside walls",
        original="people who are pushed hard enough go through walls",
        here="nobody's center enters a wall",
        why="walls are solid",
        key="crowd: {keep_out_of_walls: false}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="push of the scared",
        original="4 m^2/s^2 over the distance from body to robot, whatever that"
        " is: inside the body it pulls",
        here="that distance counts as 0.05 m at least",
        why="it grows beyond all bounds, and changes its sign",
        key=_KERNEL,
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="numbers of groups",
        original="people with the same number, -1 aside, are a group",
        here="a group has a number from 0 on",
        why="no number is needed for each who walks alone",
        key=_KERNEL,
        by_profile=True,
    ),
)

_BEHAVIORS = (
    Difference(
        area="behaviors",
        name="who reacts, when idle",
        original="never feels the robot, and walks through it",
        here="feels it like a person, while no reaction is active",
        why="people do not walk through robots",
        key=_TREE + "{ignore_robot_when_idle: true}",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="memory of the scared",
        original="who turns away from the robot forgets it, and turns back",
        here="keeps it in mind for 1 s, and as long as it is near",
        why="they would turn to and fro every few steps",
        key=_TREE + "{type: scared, memory: 0.0, track: false}",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="occlusion",
        original="people see the robot through walls",
        here="walls hide it",
        why="it is written there as something to do",
        key=_TREE + "{occlusion: false}",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="where the threatening go",
        original="beside it: sine and cosine of its heading are swapped",
        here="1.1 m in front of it",
        why="they are meant to get in its way",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="turning to the robot",
        original="the surprised turn 0.0314 rad a step, however long that is,"
        " and beyond a robot on the right; the curious and the threatening turn"
        " at once",
        here="all turn at pi rad/s at most, and no further than to the robot",
        why="a rate does not hang on the time step",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="velocity of who stands",
        original="the surprised, the curious near the robot, and whoever has"
        " reached a goal keep the velocity that others see",
        here="it is zero",
        why="others would make way for somebody who does not come",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="speed of the curious",
        original="1.8 m/s times distance over 10 m, whatever their maximum",
        here="never above it",
        why="a maximum is one",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="reaching a goal",
        original="takes a step of standing still, in which the behavior status"
        " stays as it was",
        here="the step goes on to the next goal",
        why="people do not stop in passing",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="who drops goals",
        original="the tree, and the step of the crowd, which may end within"
        " the radius",
        here="the tree alone",
        why="one decides",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="a single cyclic goal",
        original="freezes the person 0.1 m before it, at full speed for others",
        here="the person stands at the goal",
        why="the goal is dropped, and is the next one",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="cyclic by default",
        original="the first goal follows the last, unless it is said not to",
        here="it does not, unless it is said to",
        why="who arrives stays",
        key="humans[].cyclic: true",
        by_profile=True,
    ),
    Difference(
        area="behaviors",
        name="yaw at rest",
        original="jumps to 0 where the velocity is exactly zero",
        here="stays below 1e-6 m/s",
        why="a direction of no velocity is none",
        key=_KERNEL,
        by_profile=True,
    ),
)

_STEPS = (
    Difference(
        area="steps",
        name="one after the other",
        original="who reacts moves by where people are who have moved already:"
        " those whose turn it was before",
        here="all see one snapshot, and nothing hangs on the order but the last"
        " digits of sums",
        why="who is listed first must not be ahead",
        by_profile=True,
    ),
    Difference(
        area="steps",
        name="order of people",
        original="that of a hash table of their numbers, as GCC's library has"
        " it",
        here="that of the scenario, on which only last digits hang",
        why="numbers are names",
        by_profile=True,
    ),
    Difference(
        area="steps",
        name="length of a step",
        original="who could react, but does not, walks with a step that was"
        " passed on as text of 6 decimals",
        here="exact",
        why="1/30 s is not 0.033333 s",
        by_profile=True,
    ),
    Difference(
        area="steps",
        name="single precision",
        original="yaw, radius, goal radius, speeds, and where the robot is for"
        " those who react are rounded to it, and bearings computed in it",
        here="double precision",
        why="there is no reason for less",
        by_profile=True,
    ),
    Difference(
        area="steps",
        name="the robot's number",
        original="a robot with the number of a person is unseen by that person",
        here="numbers of robots and people are apart",
        why="they are different things",
    ),
)

_SERVICES = (
    Difference(
        area="services",
        name="the first call",
        original="only tells who there is",
        here="moves people as any other",
        why="a call does what it is called",
    ),
    Difference(
        area="services",
        name="reset_agents",
        original="sets places, and leaves goals and timers",
        here="starts goals and reactions again, too",
        why="a trial must not hang on the one before",
    ),
    Difference(
        area="services",
        name="missing keys of agents.yaml",
        original="have defaults: max_vel 1.0, goal_radius 0.0, init_pose 0",
        here="the same, but a goal radius of 0.001 m; a start must be given",
        why="the import says what it took for granted",
    ),
    Difference(
        area="services",
        name="random reactions in agents.yaml",
        original="draws duration, speed and distance of a reaction anew at each"
        " start",
        here="the import draws them once, by the person's number, and writes"
        " them into the scenario",
        why="a scenario says what happens in it",
    ),
)

_BODIES = (
    Difference(
        area="forces",
        name="bodies",
        original="people are points: they share the floor with each other and"
        " walk through robots",
        here="at the end of a step no two bodies overlap",
        why="what people and robots do when they touch is what is studied",
        key="crowd: {keep_apart: false}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="following",
        original="people walk at full speed at any density",
        here="people keep a time gap to whoever walks ahead of them, and step"
        " aside for who comes towards them",
        why="speeds and flows through doors are then those measured",
        key="crowd: {model: {time_gap: 0.0, speed_matching: 0.0}}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="narrow doors",
        original="bodies pass through each other",
        here="of two who meet at a passage too narrow for both, the one who is"
        " farther from it waits beside it until the other one is out",
        why="bodies that are kept apart block each other",
        key="crowd: {keep_apart: false}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="passing robots",
        original="who does not react to the robot feels it as one more person,"
        " and grazes it",
        here="who sees one in the way within 3 m walks past it with a gap of"
        " 0.6 m, where there is room",
        why="people do not graze robots",
        key="crowd: {robot_gap: 0.0}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="groups",
        original="pull their members together, wherever these walk to",
        here="only those walk together who go the same way",
        why="members with other goals, or who have arrived, hold back all the"
        " others for ever",
        key="crowd: {groups_part: false}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="standing",
        original="forces move people who are at their goal or have none",
        here="they stand: only bodies and strong forces move them, and they"
        " come back",
        why="whoever stands trembles, or is carried off, without",
        key="crowd: {standing: false}",
        by_profile=True,
    ),
    Difference(
        area="forces",
        name="rates of change",
        original="velocities and headings change at once",
        here="velocities change by at most 3.5 m/s^2, headings by 4 rad/s",
        why="people cannot do more",
        key="crowd: {max_acceleration: null, max_turn_rate: null}",
        by_profile=True,
    ),
)

PEOPLE_ROWS: tuple[Difference, ...] = (
    *_FORCES,
    *_BODIES,
    *_BEHAVIORS,
    *_STEPS,
    *_SERVICES,
)
