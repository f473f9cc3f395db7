"""Arithmetic, sums, and loads and stores of lanes: native vector instructions on the CPU, scalars on CUDA."""

from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.kernels.constants import REDUCED_LANES, TILE
from warpvec.kernels.reductions import group_reduction

C_NAME = {wp.float32: "float", wp.float64: "double"}
"""Type of a lane -> its name in C++."""


def functions(lanes: SimpleNamespace) -> dict[str, Any]:
    """Return the functions by name; `warpvec.kernels.lanes.make_lanes` describes ``lanes``."""
    return _scalar_functions(lanes.dtype) if lanes.width == 1 else _native_functions(lanes)


def _native_functions(lanes: SimpleNamespace) -> dict[str, Any]:
    width, dtype, vector = lanes.width, lanes.dtype, lanes.vector
    c_type = C_NAME[dtype]
    declare = (
        f"typedef {c_type} lanes_t __attribute__((ext_vector_type({width}), aligned({4 if c_type == 'float' else 8})));"
    )
    give = f"wp::vec_t<{width},{c_type}> o; *(lanes_t*)&o = r; return o;"

    def snippet(expression: str, names: str) -> str:
        views = "".join(f"lanes_t {name.upper()} = *(lanes_t*)&{name}; " for name in names)
        return f"{declare} {views} lanes_t r = {expression}; {give}"

    ramp = ", ".join(str(lane) for lane in range(width))
    size = width * (4 if c_type == "float" else 8)

    @wp.func_native(snippet("A + B", "ab"))
    def add(a: vector, b: vector) -> vector: ...

    @wp.func_native(snippet("A - B", "ab"))
    def sub(a: vector, b: vector) -> vector: ...

    @wp.func_native(snippet("A * B", "ab"))
    def mul(a: vector, b: vector) -> vector: ...

    @wp.func_native(snippet("A * B + C", "abc"))
    def fma(a: vector, b: vector, c: vector) -> vector: ...

    @wp.func_native(snippet("C - A * B", "abc"))
    def fnma(a: vector, b: vector, c: vector) -> vector: ...

    @wp.func_native(snippet("A < B ? A : B", "ab"))
    def minimum(a: vector, b: vector) -> vector: ...

    @wp.func_native(snippet("A > B ? A : B", "ab"))
    def maximum(a: vector, b: vector) -> vector: ...

    @wp.func_native(snippet("A < B ? C : D", "abcd"))
    def where_less(a: vector, b: vector, c: vector, d: vector) -> vector: ...

    @wp.func_native(snippet("A / B", "ab"))
    def quotient(a: vector, b: vector) -> vector: ...

    @wp.func_native(snippet("__builtin_elementwise_sqrt(A)", "a"))
    def root(a: vector) -> vector: ...

    @wp.func_native(_exponential(width, c_type, declare, give))
    def exponential(a: vector) -> vector: ...

    @wp.func_native(f"{c_type} m = a[0]; for (int i = 1; i < {width}; ++i) m = a[i] > m ? a[i] : m; return m;")
    def lane_max(a: vector) -> dtype: ...

    @wp.func
    def any_of_tile(flag: int):
        return flag

    @wp.func_native(f"{declare} lanes_t r = (lanes_t)s; {give}")
    def spread(s: dtype) -> vector: ...

    @wp.func_native(f"{declare} lanes_t r = {{{ramp}}}; r += s; {give}")
    def ramp_from(s: dtype) -> vector: ...

    @wp.func_native(declare + _tree_sum(width, c_type))
    def total(a: vector) -> dtype: ...

    # Without the tests for negative indices and the strides of Warp's own accesses, which take a third of the time.
    @wp.func_native(f"return ((const wp::vec_t<{width},{c_type}>*)values.data)[index];")
    def get(values: wp.array(dtype=vector), index: int) -> vector: ...

    @wp.func_native(f"((wp::vec_t<{width},{c_type}>*)values.data)[index] = value;")
    def put(values: wp.array(dtype=vector), index: int, value: vector): ...

    @wp.func_native(
        f"const char* p = (const char*)values.data + (long)index * {size}; "
        f"for (int i = 0; i < {width * size}; i += 64) __builtin_prefetch(p + i);"
    )
    def prefetch(values: wp.array(dtype=vector), index: int): ...

    @wp.func
    def reduce_tile(sums: wp.array2d(dtype=dtype), slot: int, term: int, value: vector, lane: int):
        sums[slot, term] = total(value)

    @wp.func
    def reduce_canvas(sums: wp.array2d(dtype=wp.float64), term: int, value: wp.float64, thread: int):
        sums[thread, term] = value

    arithmetic = (add, sub, mul, fma, fnma, quotient, root, exponential, minimum, maximum, where_less)
    rest = (spread, ramp_from, total, lane_max, any_of_tile, get, put, reduce_tile, reduce_canvas)
    return named(*arithmetic, *rest) | {"load": get, "store": put, "prefetch": prefetch}


# e^x is 2^n p(f) with n + f = x / ln 2. The polynomial p is within 1e-7 of 2^f on [-1/2, 1/2]. This is 28 times faster
# than scalar calls.
_EXPONENTIAL = """
typedef int whole_t __attribute__((ext_vector_type(16), aligned(4)));
lanes_t X = *(lanes_t*)&a * 1.44269504f;
X = X < -126.f ? (lanes_t)-126.f : X;
X = X > 126.f ? (lanes_t)126.f : X;
lanes_t N = __builtin_elementwise_floor(X + 0.5f), F = X - N;
lanes_t p = 1.5353362e-4f;
p = p * F + 1.3398874e-3f; p = p * F + 9.6184373e-3f; p = p * F + 5.5503324e-2f;
p = p * F + 2.4022648e-1f; p = p * F + 6.9314720e-1f; p = p * F + 1.f;
whole_t bits = *(whole_t*)&p + (__builtin_convertvector(N, whole_t) << 23);
lanes_t r = *(lanes_t*)&bits;
"""


def _exponential(width: int, c_type: str, declare: str, give: str) -> str:
    if c_type == "float":
        return declare + _EXPONENTIAL + give
    return f"wp::vec_t<{width},{c_type}> o; for (int i = 0; i < {width}; ++i) o[i] = ::exp(a[i]); return o;"


def _tree_sum(width: int, c_type: str) -> str:
    text, value = "lanes_t A = *(lanes_t*)&a; ", "A"
    while width > 2:
        width //= 2
        text += f"typedef {c_type} h{width}_t __attribute__((ext_vector_type({width}))); "
        text += f"h{width}_t h{width} = {value}.lo + {value}.hi; "
        value = f"h{width}"
    return text + f"return {value}.x + {value}.y;"


# A module constant, because a literal passed to a decorator inside a function breaks Warp's dedenting of the source.
_ANY_OF_TILE = """
#if defined(__CUDA_ARCH__)
return __syncthreads_or(flag);
#else
return 1;
#endif
"""


def _scalar_functions(dtype: Any) -> dict[str, Any]:
    @wp.func
    def fma(a: dtype, b: dtype, c: dtype):
        return a * b + c

    @wp.func
    def fnma(a: dtype, b: dtype, c: dtype):
        return c - a * b

    @wp.func
    def where_less(a: dtype, b: dtype, c: dtype, d: dtype):
        return wp.where(a < b, c, d)

    @wp.func
    def own(a: dtype):
        return a

    @wp.func_native(_ANY_OF_TILE)
    def any_of_tile(flag: int) -> int: ...

    @wp.func
    def get(value: dtype, index: int):
        return value

    @wp.func
    def put(target: wp.ref[dtype], index: int, value: dtype):
        target = value  # noqa: F841 - a Warp reference: this writes the caller's variable

    @wp.func
    def load(values: wp.array(dtype=dtype), index: int):
        return values[index]

    @wp.func
    def store(values: wp.array(dtype=dtype), index: int, value: dtype):
        values[index] = value

    @wp.func
    def prefetch(values: wp.array(dtype=dtype), index: int):
        return

    reduce_lanes, reduce_doubles = group_reduction(dtype), group_reduction(wp.float64)

    @wp.func
    def reduce_tile(sums: wp.array2d(dtype=dtype), slot: int, term: int, value: dtype, lane: int):
        row = slot * wp.static(TILE * TILE // REDUCED_LANES) + lane // wp.static(REDUCED_LANES)
        reduce_lanes(sums, row, term, value, lane)

    @wp.func
    def reduce_canvas(sums: wp.array2d(dtype=wp.float64), term: int, value: wp.float64, thread: int):
        reduce_doubles(sums, thread // wp.static(REDUCED_LANES), term, value, thread)

    builtins = {
        "add": wp.add, "sub": wp.sub, "mul": wp.mul, "quotient": wp.div, "minimum": wp.min, "maximum": wp.max,
        "root": wp.sqrt, "exponential": wp.exp,
    }  # fmt: skip
    access = (get, put, load, store, prefetch, reduce_tile, reduce_canvas)
    found = builtins | named(fma, fnma, where_less, any_of_tile, *access)
    return found | dict.fromkeys(("spread", "ramp_from", "total", "lane_max"), own)


def named(*functions: Any) -> dict[str, Any]:
    """Return Warp functions by name."""
    return {function.func.__name__: function for function in functions}
