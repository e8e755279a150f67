from __future__ import annotations

import ctypes
import gc
from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from flexros.compile import CompiledFunction, compile_function
from flexros.errors import InputError

x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 2, 3)
FUNCTION = ca.Function("work", [x, y], [y.T @ x, y * 2], ["x", "y"], ["product", "twice"])


@pytest.fixture(scope="module")
def compiled() -> CompiledFunction:
    return compile_function(FUNCTION)


def test_shapes_and_names_are_those_of_the_function(compiled: CompiledFunction) -> None:
    assert compiled.input_shapes == ((2,), (2, 3))
    assert compiled.output_shapes == ((3,), (2, 3))
    assert (compiled.n_in, compiled.n_out) == (2, 2)
    assert compiled.output_names == ("product", "twice")


def test_call_takes_matrices_in_any_memory_order(compiled: CompiledFunction) -> None:
    matrix = np.arange(6.0).reshape(2, 3)
    for given in (matrix, np.asfortranarray(matrix), matrix.tolist()):
        product, twice = compiled([1.0, 10.0], given)
        assert product.tolist() == [30.0, 41.0, 52.0]
        assert twice.tolist() == (2 * matrix).tolist()


def test_address_follows_the_calling_convention(compiled: CompiledFunction) -> None:
    arrays = [np.array([1.0, 10.0]), np.asfortranarray(np.ones((2, 3))), np.zeros(3), np.zeros((2, 3), order="F")]
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(compiled.address)(*(a.ctypes.data for a in arrays))
    assert arrays[2].tolist() == [11.0, 11.0, 11.0]


def test_bound_call_works_on_its_arrays(compiled: CompiledFunction) -> None:
    given, matrix = np.zeros(2), np.ones((2, 3), order="F")
    product, twice = np.zeros(3), np.zeros((2, 3), order="F")
    call = compiled.bind(given, matrix, product, twice)
    given[:] = [1.0, 2.0]
    call()
    assert product.tolist() == [3.0, 3.0, 3.0]
    given[:] = [5.0, 2.0]
    call()
    assert product.tolist() == [7.0, 7.0, 7.0]


def test_bound_call_keeps_code_and_arrays_alive() -> None:
    product = np.zeros(3)
    call = compile_function(FUNCTION).bind(
        np.array([1.0, 1.0]), np.ones((2, 3), order="F"), product, np.zeros((2, 3), order="F")
    )
    gc.collect()
    call()
    assert product.tolist() == [2.0, 2.0, 2.0]


def test_threads_share_a_function(compiled: CompiledFunction) -> None:
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(lambda k: compiled([k, 0.0], np.ones((2, 3)))[0][0], range(200)))
    assert results == list(range(200))


def test_wrong_number_of_inputs_is_named(compiled: CompiledFunction) -> None:
    with pytest.raises(InputError, match=r"work takes 2 inputs \['x', 'y'\], 1 were given"):
        compiled([1.0, 2.0])


def test_wrong_shape_is_named(compiled: CompiledFunction) -> None:
    with pytest.raises(InputError, match=r"work: input 'y' has shape \(3, 2\), needed is \(2, 3\)"):
        compiled([1.0, 2.0], np.ones((3, 2)))


def test_binding_refuses_an_array_that_it_would_have_to_copy(compiled: CompiledFunction) -> None:
    right = [np.zeros(2), np.zeros((2, 3), order="F"), np.zeros(3), np.zeros((2, 3), order="F")]
    read_only = np.zeros(3)
    read_only.setflags(write=False)
    for k, wrong in ((0, np.zeros(2, dtype=np.float32)), (1, np.zeros((2, 3))), (2, read_only), (3, np.zeros((3, 2)))):
        arrays = [*right[:k], wrong, *right[k + 1 :]]
        with pytest.raises(InputError, match=f"array '{['x', 'y', 'product', 'twice'][k]}' has shape"):
            compiled.bind(*arrays)


def test_binding_needs_all_arrays(compiled: CompiledFunction) -> None:
    with pytest.raises(InputError, match="work binds 4 arrays"):
        compiled.bind(np.zeros(2))


def test_lanes_stand_behind_the_elements() -> None:
    compiled = compile_function(FUNCTION, lanes=4)
    assert compiled.input_shapes == ((2, 4), (6, 4))
    product, _ = compiled(np.outer([1.0, 10.0], [1.0, 2.0, 3.0, 4.0]), np.ones((6, 4)))
    assert product.tolist() == [[11.0, 22.0, 33.0, 44.0]] * 3


def test_impossible_number_of_lanes_is_refused() -> None:
    with pytest.raises(InputError, match="lanes = 3 is not possible: allowed are 1, 2, 4, 8, 16"):
        compile_function(FUNCTION, lanes=3)
