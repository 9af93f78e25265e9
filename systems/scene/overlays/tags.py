"""Name tags: pictures of text on a board for Meshcat and for films."""

from functools import lru_cache
import io

from PIL import Image, ImageDraw, ImageFont
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Rgba

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import Activity, Posture, Signal

# The height of a board, and the height of its center above the floor, in m.
TAG_HEIGHT = 0.26
TAG_Z = 1.97

# The height of the center of a bubble with what a person says.
BUBBLE_Z = TAG_Z + 0.32

# The same of boards above robots, in meters.
ROBOT_TAG_Z = 0.8

# The size of letters in the picture of a board, in pixels.
_LETTERS = 28

# The colors of letters and board: of people who do not react to the robot, of
# people who do, and of what people say.
Colors = tuple[tuple[int, int, int], tuple[int, int, int]]
CALM: Colors = ((255, 255, 255), (44, 50, 60))
REACTING: Colors = ((255, 255, 255), (190, 20, 55))
SPEECH: Colors = ((30, 34, 40), (255, 250, 225))

# The codes of those who use a place seated, as at a desk, and of those who lie.
_WORKS, _LIES = -1.0, -2.0

# What people do, by their Activity; those that are reactions have none.
WORDS: dict[float, str] = {
    Activity.CONVERSATION: "talks",
    Activity.QUEUE: "queues",
    Activity.USE: "uses something",
    Activity.SIT: "sits",
    Activity.FOLLOW: "follows",
    Activity.ACCOMPANY: "accompanies",
    Activity.WATCH: "watches",
    Activity.GIVE_WAY: "gives way",
    Activity.GROUP_WALK: "walks in a group",
    Activity.WAIT: "waits",
    _WORKS: "works",
    _LIES: "lies",
}

_LONGEST, _LONGEST_TAG = 40, 40

# The behaviors that tags do not tell: of the usual one, and of those that are
# `ACTIVITIES`, people show what they do.
UNTOLD = frozenset(
    {"regular", "sit", "queue", "errands", "lunch", "talk", "chat", "guide"}
)

# In larger crowds, people have no tags.
CROWD = 12


def tag_text(name: str, behavior: str, activity: str = "") -> str:
    """Returns the text of a person's tag.

    The usual behavior goes without saying, and so do activities: somebody with
    the behavior "sit" also walks to the seat.
    """
    # (A tree in the file has no name but "xml".)
    if behavior in UNTOLD or behavior == "xml":
        behavior = ""
    parts = [part for part in (name, behavior, activity) if part]
    text = " \N{MIDDLE DOT} ".join(parts)
    return _cut(text, _LONGEST_TAG)


def calm_activities(signals: Array | None, n: int) -> list[str]:
    """Returns what people do that is no reaction to a robot, in a word each.

    `signals` are n rows of `layout.Signal`, or None.
    """
    if signals is None:
        return [""] * n
    rows = signals.reshape(n, -1)
    codes, posture = rows[:, Signal.ACTIVITY].copy(), rows[:, Signal.POSTURE]
    sits, uses = codes == Activity.SIT, codes == Activity.USE
    # Who still walks to a seat, or turns around before it, does not sit.
    codes[sits & (posture == Posture.STANDING)] = Activity.NONE
    codes[uses & (posture == Posture.SEATED)] = _WORKS
    codes[(sits | uses) & (posture == Posture.LYING)] = _LIES
    return [WORDS.get(code, "") for code in codes.tolist()]


def activity_text(word: str, is_still: bool) -> str:
    """Returns the word of a tag: people who walk there do not sit yet."""
    if word in ("follows", "accompanies", "walks in a group"):
        return word
    if is_still:
        return word or "stands"
    return ""


def tag_lift(tall: float) -> float:
    """Returns how much higher the tags of somebody tall are, in meters."""
    return 1.7 * max(tall - 1.0, 0.0)


def bubble_text(text: str) -> str:
    """Returns the text of a bubble with what a person says."""
    return _cut(f"\u201c{text}\u201d", _LONGEST)


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else text[: longest - 1] + "\u2026"


def tag_picture(
    text: str,
    colors: Colors = CALM,
    letters: int = _LETTERS,
    *,
    owner: Rgba | None = None,
) -> Image.Image:
    """Returns a line of text on a board as an RGBA picture.

    `colors` are those of letters and board; letters are in pixels. A dot in the
    color of its `owner` tells whose board it is, also where several are close.
    """
    dot = owner and tuple(
        round(255 * it) for it in (owner.r(), owner.g(), owner.b())
    )
    return _tag_picture(text, colors, letters, dot)


@lru_cache(maxsize=512)
def _tag_picture(
    text: str, colors: Colors, letters: int, dot: tuple[int, ...] | None
) -> Image.Image:
    ink, board = colors
    font = ImageFont.load_default(letters)
    left, _, right, _ = font.getbbox(text)
    # The dot, with its distance to the text.
    beside = letters if dot else 0.0
    size = (int(right - left + 0.9 * letters + beside), int(1.5 * letters))
    picture = Image.new("RGBA", size, (*board, 0))
    draw = ImageDraw.Draw(picture)
    draw.rounded_rectangle(
        (0, 0, size[0] - 1, size[1] - 1), 0.35 * letters, fill=(*board, 225)
    )
    if dot:
        wide, rim = round(0.7 * letters), max(round(letters / 14), 1)
        x, y = round(0.45 * letters), (size[1] - wide) // 2
        for inset, color in ((0, ink), (rim, dot)):
            disc = _disc(wide - 2 * inset)
            picture.paste((*color, 255), (x + inset, y + inset), disc)
    middle = ((size[0] + beside) / 2, size[1] / 2)
    draw.text(middle, text, fill=(*ink, 255), font=font, anchor="mm")
    return picture


def _disc(size: int) -> Image.Image:
    """Returns a disc as a mask, with smooth edges; its size is in pixels."""
    fine = Image.new("L", (8 * size, 8 * size))
    ImageDraw.Draw(fine).ellipse((0, 0, 8 * size - 1, 8 * size - 1), fill=255)
    return fine.resize((size, size), Image.Resampling.BOX)


def TagBoard(
    text: str, colors: Colors = CALM, *, owner: Rgba | None = None
) -> Mesh:
    """Returns an upright board with a text for Meshcat.

    It faces +z of its frame, with the text along +x and up along +y, like a
    picture on a screen; it is emissive. See `tag_picture`.
    """
    picture = tag_picture(text, colors, owner=owner)
    # Opaque corners: Meshcat does not support partly transparent boards.
    flat = Image.new("RGB", picture.size, colors[1])
    flat.paste(picture, mask=picture.getchannel("A"))
    png = io.BytesIO()
    flat.quantize(32).save(png, "PNG", optimize=True)
    half = TAG_HEIGHT / 2
    width = half * picture.size[0] / picture.size[1]
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    lines = ["mtllib tag.mtl", "usemtl tag"]
    lines += [f"v {a * width:.4f} {b * half:.4f} 0" for a, b in corners]
    lines += [f"vt {(a + 1) / 2:g} {(b + 1) / 2:g}" for a, b in corners]
    lines += ["vn 0 0 1", "f 1/1/1 2/2/1 3/3/1", "f 1/1/1 3/3/1 4/4/1"]
    material = "newmtl tag\nKd 0 0 0\nKa 0 0 0\nKs 0 0 0\nKe 1 1 1\n"
    material += "map_Ke tag.png\n"
    return Mesh(
        InMemoryMesh(
            mesh_file=MemoryFile("\n".join(lines) + "\n", ".obj", text),
            supporting_files={
                "tag.mtl": MemoryFile(material, ".mtl", "tag.mtl"),
                "tag.png": MemoryFile(png.getvalue(), ".png", "tag.png"),
            },
        )
    )
