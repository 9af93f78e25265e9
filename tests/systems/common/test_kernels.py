"""Kernels of fixed types are compiled when they are used, and only so."""

from concurrent.futures import ThreadPoolExecutor
import copy
from dataclasses import astuple, dataclass
import math
import pickle
import subprocess
import sys
import threading
from typing import NamedTuple

import numpy as np
import pytest

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    jit,
    jit_as,
    number_functions_apart,
    part_as,
    reads,
    unowned,
)
from hunav_drake.systems.robot.disc_step import _wrap_angle


@pytest.fixture
def scaled_sum():
    @jit_as(REAL, MATRIX, REAL)
    def kernel(rows, factor):
        total = 0.0
        for row in rows:
            for value in row:
                total += value
        return factor * total

    return kernel


def test_it_is_compiled_at_the_first_call_once(scaled_sum):
    assert not scaled_sum.overloads
    rows = np.arange(6.0).reshape(2, 3)
    assert scaled_sum(rows, 2.0) == 30.0
    rows.flags.writeable = False
    assert scaled_sum(rows, 2.0) == 30.0
    assert len(scaled_sum.overloads) == 1


def test_threads_that_need_it_at_once_wait_for_one(scaled_sum):
    together = threading.Barrier(4)

    def call(factor):
        together.wait()
        return scaled_sum(np.ones((2, 2)), factor)

    with ThreadPoolExecutor(4) as executor:
        found = list(executor.map(call, [1.0, 2.0, 3.0, 4.0]))
    assert found == [4.0, 8.0, 12.0, 16.0]


def test_views_of_unowned_arrays_are_of_the_same_numbers():
    @jit
    def lowered(rows):
        rows = unowned(rows)
        for row in rows:
            row -= row[0]
        return rows.sum()

    rows = np.arange(6.0).reshape(2, 3)
    held = sys.getrefcount(rows)
    assert lowered(rows) == 6.0
    np.testing.assert_array_equal(rows, [[0, 1, 2], [0, 1, 2]])
    assert sys.getrefcount(rows) == held
    assert unowned(rows) is rows


def test_whole_numbers_are_converted_at_any_call(scaled_sum):
    rows = np.ones((2, 2))
    assert [scaled_sum(rows, 3), scaled_sum(rows, 3)] == [12.0, 12.0]
    assert len(scaled_sum.overloads) == 1


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize(
    "rows",
    [np.ones((2, 2), np.float32), np.ones((4, 4))[::2, ::2], np.ones(3), "x"],
)
def test_other_types_are_refused_at_any_call(scaled_sum, rows, warm):
    if warm:
        scaled_sum(np.ones((1, 1)), 1.0)
    with pytest.raises(TypeError, match="No matching definition"):
        scaled_sum(rows, 1.0)


@pytest.mark.parametrize("arguments", [(), (np.ones((1, 1)),)])
def test_a_wrong_number_of_arguments_is_refused(scaled_sum, arguments):
    with pytest.raises(TypeError):
        scaled_sum(*arguments)


def test_a_kernel_that_calls_it_has_it_compiled_to_its_types(scaled_sum):
    @jit
    def twice(rows):
        return 2.0 * scaled_sum(rows, 1)

    assert twice(np.ones((2, 2))) == 8.0
    assert len(scaled_sum.overloads) == 1


def test_a_part_is_compiled_alone_only_for_python():
    @jit
    def half(number):
        return number / 2

    @jit_as(REAL, REAL)
    def quarter(number):
        return half(half(number))

    assert quarter(3.0) == 0.75
    assert len(half.overloads) == 1
    assert not half.whole().overloads
    assert [half(3.0), half(np.int64(3)), half(5.0)] == [1.5, 1.5, 2.5]
    assert len(half.whole().overloads) == 2
    assert quarter(5.0) == 1.25


PARTS = """
import sys
import numpy as np
from hunav_drake.systems.common.kernels import REAL, VECTOR, jit, jit_as

@jit
def root(number):
    if number < 0:
        raise ValueError("has no root", number)
    return np.sqrt(number)

@jit
def both(numbers):
    return root(numbers[0]), root(numbers[1])

@jit_as(REAL, VECTOR)
def added(numbers):
    a, b = both(numbers)
    return a + b

@jit_as(REAL, VECTOR)
def taken(numbers):
    a, b = both(numbers)
    return a - b

kernel = taken if sys.argv[1:] else added
print(kernel(np.array([9.0, 4.0])))
try:
    kernel(np.array([9.0, -4.0]))
except ValueError as error:
    print(error)
hits = sum(kernel.stats.cache_hits.values())
print(hits, sum(both.stats.cache_hits.values()))
"""


@pytest.mark.slow
def test_errors_in_parts_reach_python_also_from_code_on_disk(tmp_path):
    """So do those in parts that a kernel of another process has compiled."""
    path = tmp_path / "roots.py"
    path.write_text(PARTS)

    def output(*arguments):
        program = [sys.executable, path, *arguments]
        return subprocess.check_output(program, text=True).splitlines()

    told = "('has no root', -4.0)"
    assert output() == ["5.0", told, "0 0"]
    assert output() == ["5.0", told, "1 0"]
    assert output("taken") == ["1.0", told, "0 1"]
    assert output("taken") == ["1.0", told, "1 0"]


@pytest.mark.slow
def test_a_part_is_pickled_by_its_name():
    """Its machine code is that of kernels, and is not in other processes."""
    code = (
        "import pickle, sys;print(pickle.loads(sys.stdin.buffer.read())(7.0))"
    )
    told = subprocess.check_output(
        [sys.executable, "-c", code], input=pickle.dumps(_wrap_angle)
    )
    assert float(told) == pytest.approx(7.0 - 2 * math.pi)


def test_a_part_of_fixed_types_is_for_python_too():
    @part_as(REAL, REAL)
    def half(number):
        return number / 2

    @jit_as(REAL, INTEGER)
    def quarter(number):
        return half(number) / 2

    assert quarter(3) == 0.75
    assert len(half.overloads) == 1
    assert half(3.0) == 1.5
    assert half(3) == 1.5
    with pytest.raises(TypeError, match="too many arguments"):
        half(3.0, 4.0)


def test_numbers_of_python_are_those_of_kernels_in_a_part_of_fixed_types():
    @part_as(REAL, REAL)
    def square(number):
        return number * number

    assert square(4_000_000_000) == 1.6e19
    assert copy.deepcopy(square) is square
    assert pickle.loads(pickle.dumps(square)) is square


LOCKED = """
import sys, time
from hunav_drake.systems.common import kernels
from hunav_drake.systems.common.kernels import REAL, jit_as

@jit_as(REAL, REAL)
def first(number):
    return number + 1

@jit_as(REAL, REAL)
def second(number):
    return number + 2

if sys.argv[1] == "hold":
    with kernels._locked(first, waits=True):
        print("held", flush=True)
        sys.stdin.readline()
else:
    def other():
        second.compile_once(waits=False)
        print("second", len(first.overloads), len(second.overloads), flush=True)
        if sys.argv[1] == "need":
            # As for a kernel that calls it.
            first.compile(first.signature)
            first.disable_compile()

    kernels.meanwhile.append(other)
    print(first(1.0), flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("need", ["wait", "need"])
def test_who_waits_for_another_process_compiles_something_else(tmp_path, need):
    """That may need, and so compile, what is waited for."""
    path = tmp_path / "two.py"
    path.write_text(LOCKED)
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, path, "hold"], **pipes) as holder:
        assert holder.stdout.readline() == "held\n"
        with subprocess.Popen([sys.executable, path, need], **pipes) as waiting:
            assert waiting.stdout.readline() == "second 0 1\n"
            assert waiting.poll() is None
            holder.communicate("\n")
            assert waiting.stdout.readline() == "2.0\n"


@pytest.mark.slow
def test_to_load_a_scenario_takes_no_kernel():
    program = (
        "from hunav_drake import LoadScenario\n"
        "from hunav_drake.systems.crowd.motion_model import MOTION_MODELS\n"
        "from hunav_drake.systems.crowd.social_force import kernel\n"
        "LoadScenario(filename='passing')\n"
        "assert len(MOTION_MODELS) > 4\n"
        "assert not kernel.social_forces.overloads\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_two_processes_do_not_give_their_functions_the_same_numbers(scaled_sum):
    """Else a third one that reads both from disk takes one for the other."""
    scaled_sum(np.ones((1, 1)), 1.0)
    (compiled,) = scaled_sum.overloads.values()
    first = compiled.fndesc.uid
    number_functions_apart()
    try:
        second = jit(lambda: 0.0)
        second()
        (other,) = second.whole().overloads.values()
        assert abs(other.fndesc.uid - first) > 1 << 20
        assert min(first, other.fndesc.uid) > 1 << 20
    finally:
        number_functions_apart()


class Pair(NamedTuple):
    first: float
    second: float


@dataclass
class Gap:
    width: float = 0.7
    height: float = 2.0


def test_kernels_know_the_numbers_of_an_array_by_name():
    assert reads(Pair)(np.array([1.0, 2.0])) == Pair(1.0, 2.0)
    numbers = reads(Gap)(np.array(astuple(Gap())))
    assert (numbers.width, numbers.height) == (0.7, 2.0)
    assert pickle.loads(pickle.dumps(numbers)) == numbers
