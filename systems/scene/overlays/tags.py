"""Name tags: pictures of text on a board for Meshcat and for films."""

from functools import lru_cache
import io

from PIL import Image, ImageDraw, ImageFont
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh

# The height of a board, and the height of its center above the floor, in m.
TAG_HEIGHT = 0.26
TAG_Z = 1.97

# The same of boards above robots, in meters.
ROBOT_TAG_Z = 0.8

# The size of letters in the picture of a board, in pixels.
_LETTERS = 28

# The colors of letters and board, of people who do not react to the robot and
# of people who do.
_CALM = ((255, 255, 255), (44, 50, 60))
_REACTING = ((255, 255, 255), (190, 20, 55))

_LONGEST = 40


def tag_text(name: str, behavior: str, activity: str = "") -> str:
    """Returns the text of a person's tag."""
    parts = [part for part in (name, behavior, activity) if part]
    text = " \N{MIDDLE DOT} ".join(parts)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "\u2026"


@lru_cache(maxsize=512)
def tag_picture(
    text: str, reacts: bool = False, letters: int = _LETTERS
) -> Image.Image:
    """Returns a line of text on a board as an RGBA picture.

    `reacts` gives it the color of people who react; letters are in pixels.
    """
    ink, board = _REACTING if reacts else _CALM
    font = ImageFont.load_default(letters)
    left, _, right, _ = font.getbbox(text)
    size = (int(right - left + 0.9 * letters), int(1.5 * letters))
    picture = Image.new("RGBA", size, (*board, 0))
    draw = ImageDraw.Draw(picture)
    draw.rounded_rectangle(
        (0, 0, size[0] - 1, size[1] - 1), 0.35 * letters, fill=(*board, 225)
    )
    middle = (size[0] / 2, size[1] / 2)
    draw.text(middle, text, fill=(*ink, 255), font=font, anchor="mm")
    return picture


def TagBoard(text: str, reacts: bool = False) -> Mesh:
    """Returns an upright board with a text for Meshcat.

    It faces +z of its frame, with the text along +x and up along +y, like a
    picture on a screen; it is emissive.
    """
    picture = tag_picture(text, reacts)
    # Opaque corners: Meshcat does not support partly transparent boards.
    flat = Image.new("RGB", picture.size, _REACTING[1] if reacts else _CALM[1])
    flat.paste(picture, mask=picture.getchannel("A"))
    png = io.BytesIO()
    flat.quantize(16).save(png, "PNG", optimize=True)
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
