"""Changes to sound inputs, drawn from a generator: bytes, texts, tables, trees.

Each may make the input wrong, or leave it sound.
"""

import contextlib
import re

import numpy as np

NUMBERS = (
    *(0.0, -0.0, 1.0, -1.0, 0.5, 3e-7, 1e-6, 1e-9, 1e-160, 5e-324, 1e5),
    *(1e9, 1e10, -1e10, 1.1e10, 100.0, 101.0, 1e18, 1e155, 1e308),
    *(np.nan, np.inf, -np.inf, 2.0**63, -(2.0**63)),
)
WORDS = ("", "x", "1e999", "nan", "inf", "-Infinity", "1_0", "0x1", "é", "\0")

# Parts of the XML of models, and what they may become.
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_IN_XML = re.compile(rf"(?<=[\"'> ]){_NUMBER}(?=[\"'< ])")
_LISTS = re.compile(rf"(?<=[\"'>]){_NUMBER}(?: {_NUMBER})*(?=[\"'<])")
_NAMES = re.compile(r"(?<=\")[A-Za-z_]\w*(?=\")|(?<=>)[A-Za-z_]\w*(?=<)")
_ELEMENTS = re.compile(r"<([\w:]+)\b[^<>]*?(?:/>|>(?:(?!<\1\b).)*?</\1>)", re.S)
_SHAPES = re.compile(
    r"<(box|sphere|cylinder|ellipsoid)\b[^<>]*?(?:/>|>.*?</\1>)", re.S
)

_WRONG_NUMBERS = (
    *("-0.1", "0", "nan", "inf", "-inf", "-20", "1e300", "1e-300", "1e12"),
    *("a", "0x", "1,5", "--1", "${x}", "\N{SUPERSCRIPT TWO}"),
)
_WRONG_LISTS = ("", "a 0 0.1", "1 2", "1 2 3 4 5 6 7", "0 0 0", "nan nan nan")
_WRONG_NAMES = ("", "nope", "world", "a b", "\N{SNOWMAN}", "::", "x" * 300)
_MESHES = (
    *("missing.obj", "part.stl", "part.dae", "broken.obj", "flat.obj"),
    *("broken.gltf", "empty.obj", "package://nope/part.obj", "model://nope"),
    *("/nowhere/part.obj", "", "ftp://nope/part.obj", "."),
)
_SCALES = ("1 1 1", "0 0 0", "-1 1 1", "1e30 1 1", "1e-12 1 1", "nan 1 1", "a")


def pick(rng, things):
    return things[int(rng.integers(len(things)))]


def mutate_array(rng, array):
    kind = rng.integers(8)
    if kind == 0:
        return array.astype(pick(rng, [complex, int, str, bool, "f4", "M8[s]"]))
    if kind == 1:
        return array[None]
    if kind == 2:
        return array.reshape(-1)
    if kind == 3 and array.ndim:
        return array[: rng.integers(len(array) + 1)]
    if kind == 4 and array.ndim:
        return np.concatenate([array, array])
    array = array.copy()
    if array.dtype.kind == "U":
        return np.full(array.shape, pick(rng, WORDS))
    value = pick(rng, NUMBERS)
    if kind == 5 and array.ndim:
        array = array.astype(float)
        array[..., rng.integers(array.shape[-1])] = value
        return array
    if kind == 6:
        return array * value
    if array.size:
        array = array.astype(float)
        array.flat[rng.integers(array.size)] = value
    return array


def mutate_table(rng, rows):
    rows = [list(row) for row in rows]
    kind = rng.integers(7)
    row = rows[int(rng.integers(len(rows)))]
    column = int(rng.integers(len(row)))
    if kind == 0:
        row[column] = pick(rng, WORDS)
    elif kind == 1:
        for row in rows:
            del row[column]
    elif kind == 2:
        rows.remove(row)
    elif kind == 3:
        rows.append(list(row))
    elif kind == 4:
        value = pick(rng, NUMBERS)
        for row in rows[1:]:
            # What was changed before may be no number.
            with contextlib.suppress(ValueError):
                if column != 1:
                    row[column] = repr(float(row[column]) * value)
    else:
        row[column] = repr(pick(rng, NUMBERS))
    return rows


def mutate_bytes(rng, data):
    data = bytearray(data)
    at = int(rng.integers(len(data)))
    kind = rng.integers(4)
    if kind == 0:
        data[at] = int(rng.integers(256))
    elif kind == 1:
        del data[at : at + int(rng.integers(1, 40))]
    elif kind == 2:
        data[at:at] = bytes(rng.integers(0, 256, 4, dtype=np.uint8))
    else:
        del data[at:]
    return bytes(data)


def mutate_json(rng, document):
    """Replaces an entry somewhere in a document, which it changes."""
    values = (*NUMBERS[:20], 10**30, None, True, "", "fast", [], {}, [1, 2])
    while document:
        place = pick(
            rng,
            list(document)
            if isinstance(document, dict)
            else list(range(len(document))),
        )
        entry = document[place]
        if isinstance(entry, dict | list) and entry and rng.random() < 0.8:
            document = entry
            continue
        if isinstance(document, dict) and rng.random() < 0.2:
            del document[place]
        else:
            document[place] = pick(rng, values)
        return


def mutate_text(rng, text):
    """Changes a word of a text, wherever it is, or some of its bytes."""
    if rng.random() < 0.3:
        return mutate_bytes(rng, text.encode()).decode(errors="replace")
    words = list(re.finditer(r"[^\s<>=\"'{}\[\],:]+", text))
    word = pick(rng, words)
    kind = rng.integers(4)
    if kind == 0:
        new = ""
    elif kind == 1:
        new = pick(rng, words)[0]
    elif kind == 2:
        new = repr(float(pick(rng, NUMBERS)))
    else:
        new = pick(rng, (*WORDS, "x" * 100_000, "..", "a b", "1" * 400))
    return text[: word.start()] + new + text[word.end() :]


def mutate_lines(rng, text):
    """Takes a line of a text out, or puts it in once more."""
    lines = text.splitlines(keepends=True)
    at = int(rng.integers(len(lines)))
    to = int(rng.integers(len(lines)))
    size = int(rng.integers(1, 4))
    part = lines[at : at + size]
    if rng.random() < 0.5:
        del lines[at : at + size]
    else:
        lines[to:to] = part
    return "".join(lines)


def mutate_model(rng, text):
    """Changes a number, list, name, shape or element of a robot's model."""
    pattern, wrong = pick(
        rng,
        (
            *3 * [(_IN_XML, _WRONG_NUMBERS)],
            (_LISTS, _WRONG_LISTS),
            (_NAMES, _WRONG_NAMES),
            (_SHAPES, None),
            (_ELEMENTS, ("", "twice")),
        ),
    )
    place = pick(rng, list(pattern.finditer(text)))
    if wrong is None:
        mesh, scale = pick(rng, (*_MESHES, "part.obj")), pick(rng, _SCALES)
        new = f'<mesh filename="{mesh}" scale="{scale}"/>'
        if "<sdf" in text:
            new = f"<mesh><uri>{mesh}</uri><scale>{scale}</scale></mesh>"
    else:
        new = pick(rng, wrong)
        new = 2 * place[0] if new == "twice" else new
    return text[: place.start()] + new + text[place.end() :]
