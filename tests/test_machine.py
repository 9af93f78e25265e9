"""What the last bits of results depend on: what is told, and nothing else."""

import ast
import json
import os
from pathlib import Path
import re
import subprocess
import sys

from llvmlite import binding
import pytest

from hunav_drake.trial.machine import MACHINE_TRAITS, machine_traits
from hunav_drake.trial.provenance import MakeProvenance
from tests.architecture import modules

ROOT = Path(__file__).resolve().parents[1]

# What NumPy and SciPy leave to BLAS or LAPACK, whose kernels differ between
# processors: functions, by whatever way they are reached, and modules.
FUNCTIONS = {
    *("dot", "vdot", "vecdot", "inner", "matmul", "matvec", "vecmat"),
    *("tensordot", "einsum_path", "multi_dot", "convolve", "correlate"),
    *("polyfit", "lstsq", "cov", "corrcoef", "multivariate_normal", "linalg"),
    *("roots", "gaussian_kde", "linregress", "curve_fit", "savgol_filter"),
}
MODULES = {"linalg", "blas", "lapack", "optimize", "interpolate", "signal"}

# Whose results are for the eyes alone.
PICTURES = (
    *("hunav_drake/views/", "hunav_drake/report/plots/"),
    *("systems/scene/overlays/", "systems/scene/meshes.py"),
    *("systems/scene/human_body.py", "systems/scene/surroundings.py"),
)
# What reads, judges and fits recordings runs before trials, and after them.
RECORDINGS = (
    *("hunav_drake/tracks/", "hunav_drake/validation/recorded.py"),
    "hunav_drake/validation/fitting.py",
)
# And what else may stay, with the reason.
SPLINES = "of recorded people: of what a file has, before a trial"
COUNTS = "numbers of cells, which are exact"
POSES = "products of Drake's poses, which are its own"
ALLOWED = {
    "ndimage.convolve(full.astype(float), around, mode='constant')": COUNTS,
    "X_WM @ X_MB": POSES,
    "X_WL @ inspector.GetPoseInFrame(geometry) @ box.pose()": POSES,
    "X_above @ X": POSES,
    "X_WG.rotation() @ np.array(normal)": POSES,
    "model.pose()[0] @ X": POSES,
    "X_WM @ X": POSES,
    "X @ _placement(it, self._members).inverse()": POSES,
    "X @ _placement(member, members).inverse()": POSES,
    "frames.pose_of(link.name).inverse() @ X_MG": POSES,
    "X_WM @ frames.pose_of(link.name)": POSES,
    "X_WL @ X_LG": POSES,
    "X_WM @ part.X_WG": POSES,
    "(X_WG @ corners.T).T.reshape(-1, 3, 3)": POSES,
    "(X_WG @ _points(part.shape).T).T": POSES,
    "X_WB @ facts.X_RB.inverse()": POSES,
    "X_BL @ inspector.GetPoseInFrame(geometry)": POSES,
    "(box.pose() @ (corners * box.half_width()).T).T": POSES,
    "X_BG @ points.T": POSES,
    "turn @ tilt @ ahead": POSES,
    "(X_WG @ points.T).T": POSES,
    "from scipy.interpolate import CubicSpline": SPLINES,
    "from scipy.interpolate import UnivariateSpline": SPLINES,
    "np.linalg.svd(centered, compute_uv=False)": "tells whether the corners of"
    " a polygon lie on a line, to a millimeter",
}

# The kernels of OpenBLAS that CI looks at, and what they need. (Its wheels have
# no Zen of their own, but take Haswell.)
KERNELS = {"Sandybridge": "avx", "Haswell": "avx2", "SkylakeX": "avx512vl"}


def blas_calls(text):
    """Yields what of a Python text may reach BLAS, as source."""
    parents = {
        child: node
        for node in ast.walk(ast.parse(text))
        for child in ast.iter_child_nodes(node)
    }
    for node in parents:
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = {alias.name for alias in node.names}
            parts = set(".".join(names).split("."))
            if isinstance(node, ast.ImportFrom):
                parts |= set((node.module or "").split("."))
                names.add(node.module or "")
            numeric = any(n.startswith(("numpy", "scipy")) for n in names)
            if numeric and parts & (FUNCTIONS | MODULES):
                yield ast.unparse(node)
            continue
        optimized = (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).endswith("einsum")
            and any(word.arg == "optimize" for word in node.keywords)
        )
        product = isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(
            node.op, ast.MatMult
        )
        known = isinstance(node, ast.Attribute) and node.attr in FUNCTIONS
        if not (optimized or product or known):
            continue
        # The whole call, or the whole product.
        while isinstance(parents[node], ast.Attribute) or (
            isinstance(parents[node], ast.Call) and parents[node].func is node
        ):
            node = parents[node]
        inner = isinstance(parents[node], ast.BinOp) and isinstance(
            parents[node].op, ast.MatMult
        )
        if not (product and inner):
            yield ast.unparse(node)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("np.dot(a, b) / 2", "np.dot(a, b)"),
        ("a.dot(b)", "a.dot(b)"),
        ("x = a @ b @ c", "a @ b @ c"),
        ("a @= b", "a @= b"),
        ("np.linalg.norm(a)", "np.linalg.norm(a)"),
        ("np.einsum('ij,jk', a, b, optimize=True)", "np.einsum('ij,jk', a, b,"),
        ("from scipy.optimize import minimize", "from scipy.optimize import"),
        ("from numpy import dot", "from numpy import dot"),
        ("import numpy.linalg as la", "import numpy.linalg as la"),
        ("np.random.default_rng().multivariate_normal(m, c)", "np.random"),
    ],
)
def test_the_search_finds_what_reaches_blas(text, found):
    (told,) = blas_calls(text)
    assert told.startswith(found)


@pytest.mark.parametrize(
    "text",
    [
        "(a * b).sum()",
        "np.einsum('ij,jk->ik', a, b)",
        "@decorated\ndef f(inner, dot): return inner + dot",
        "from hunav_drake.systems.planning.mppi.mppi import optimize",
    ],
)
def test_the_search_finds_nothing_else(text):
    assert not list(blas_calls(text))


@pytest.mark.slow
def test_no_metric_and_no_state_goes_through_blas():
    used = set()
    for path in modules().values():
        place = path.resolve().relative_to(ROOT).as_posix()
        if place.startswith((*PICTURES, *RECORDINGS)):
            continue
        for call in blas_calls(path.read_text()):
            assert call in ALLOWED, f"{place}: {call}: sum in a fixed order"
            used.add(call)
    assert used == set(ALLOWED)


def run(code, **variables):
    """Returns what code prints as JSON in a process with other variables."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    return json.loads(done.stdout.splitlines()[-1])


TELL_TRAITS = """
import json
from hunav_drake.trial.machine import machine_traits
print(json.dumps(machine_traits()))
"""


@pytest.mark.slow
def test_results_tell_what_their_bits_depend_on():
    traits = machine_traits()
    assert traits.keys() == MACHINE_TRAITS.keys()
    assert all(traits.values())
    assert traits.items() <= MakeProvenance("", 0).items()
    assert run(TELL_TRAITS) == traits


@pytest.mark.slow
def test_variables_change_what_they_are_told_to():
    here = machine_traits()
    other = run(
        TELL_TRAITS,
        NUMBA_CPU_NAME="generic",
        NPY_DISABLE_CPU_FEATURES=here["numpy_simd"].removeprefix("baseline"),
        GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2",
        OPENBLAS_CORETYPE="Sandybridge",
        OPENBLAS_NUM_THREADS="1",
        NUMBA_NUM_THREADS="1",
    )
    assert other.pop("numpy_simd") == "baseline"
    assert other.pop("numba_target").startswith("generic ")
    assert other.pop("c_library").endswith(" glibc.cpu.hwcaps=-AVX2")
    assert other.items() <= here.items()


def test_the_docs_have_the_same_list():
    page = (ROOT / "docs" / "repeatability.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", page, re.M)
    assert dict(rows) == {k: it.about for k, it in MACHINE_TRAITS.items()}


TELL_FORCES = """
import hashlib, json
import numpy as np
from hunav_drake.systems.crowd.social_force.fast_kernel import people_forces
from hunav_drake.systems.people.parameters import NUM_PARAMETERS
random = np.random.default_rng(0)
weights = np.tile(np.linspace(0.1, 3, NUM_PARAMETERS), (300, 1))
found = []
for n in (5, 40, 300):
    states = random.uniform(-6, 6, (n, 6))
    for mixed in (0.0, 1e-3):
        weights[0] += mixed
        forces = people_forces(states, weights[:n], 1e-9)
        assert np.isfinite(forces).all() and forces.any()
        found.append(hashlib.sha256(forces.tobytes()).hexdigest())
print(json.dumps(found))
"""


@pytest.mark.slow
def test_kernels_read_from_disk_give_what_those_just_compiled_gave(tmp_path):
    """Each has copies of others inlined, of which another may run then."""
    compiled, loaded = (
        run(TELL_FORCES, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2)
    )
    assert any(tmp_path.rglob("*.nbc"))
    assert loaded == compiled


def test_nothing_is_compiled_with_fast_mathematics():
    for path in (ROOT / "systems").rglob("*.py"):
        assert "fastmath=" not in path.read_text(), path


TELL_KERNEL = """
import ctypes, json, pathlib
import numpy
folder = pathlib.Path(numpy.__file__).parents[1] / "numpy.libs"
names = set()
for file in folder.glob("lib*openblas*"):
    name = ctypes.CDLL(str(file)).scipy_openblas_get_corename64_
    name.restype = ctypes.c_char_p
    names.add(name().decode())
print(json.dumps(sorted(names)))
"""

TELL_TRIALS = """
import json
from tests.test_golden import cases, facts
print(json.dumps([facts(*case) for case in cases() if case[1] == 0]))
"""


@pytest.fixture(scope="module")
def trials():
    return run(TELL_TRIALS)


@pytest.mark.slow
@pytest.mark.parametrize("kernel", KERNELS)
def test_trials_are_the_same_with_other_kernels_of_blas(kernel, trials):
    needed = KERNELS[kernel]
    if f"+{needed}," not in binding.get_host_cpu_features().flatten() + ",":
        pytest.skip(f"{kernel} needs {needed}, which this processor has not")
    told = run(TELL_KERNEL, OPENBLAS_CORETYPE=kernel)
    if told == []:
        pytest.skip("NumPy brings no OpenBLAS of its own here")
    assert told == [kernel]
    assert run(TELL_TRIALS, OPENBLAS_CORETYPE=kernel) == trials
