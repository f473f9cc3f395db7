"""Integer lanes, and gathers and scatters: each lane reads or writes a place of its own.

They complete ``real_lanes.py`` for kernels whose lanes are edges: 16 edges at a time on the CPU, one on CUDA. Sixteen
loads and stores one after another are as fast as the gather of AVX-512, and lanes may scatter to the same place.
"""

from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.kernels.real_lanes import C_NAME, named


def functions(lanes: SimpleNamespace) -> dict[str, Any]:
    """Return the functions by name; `warpvec.kernels.lanes.make_lanes` describes ``lanes``."""
    return _scalar_functions(lanes) if lanes.width == 1 else _native_functions(lanes)


def _native_functions(lanes: SimpleNamespace) -> dict[str, Any]:
    width, dtype, vector, vec2, whole = lanes.width, lanes.dtype, lanes.vector, lanes.vec2, lanes.whole
    real = C_NAME[dtype]
    align = 4 if real == "float" else 8
    types = (
        f"typedef {real} lanes_t __attribute__((ext_vector_type({width}), aligned({align}))); "
        f"typedef int whole_t __attribute__((ext_vector_type({width}), aligned(4))); "
    )
    give = f"wp::vec_t<{width},{real}> o; *(lanes_t*)&o = r; return o;"
    give_whole = f"wp::vec_t<{width},int> o; *(whole_t*)&o = r; return o;"
    each = f"for (int i = 0; i < {width}; ++i) "
    first = f"whole_t L = {{{', '.join(str(lane) for lane in range(width))}}}; "

    def views(reals: str, wholes: str) -> str:
        text = "".join(f"lanes_t {name.upper()} = *(lanes_t*)&{name}; " for name in reals)
        return types + text + "".join(f"whole_t {name.upper()} = *(whole_t*)&{name}; " for name in wholes)

    def gather(result: str, pointer: str, place: str) -> str:
        """Read ``pointer[place]`` for each lane i."""
        return f"{views('', 'k')} {result}_t r; {each} r[i] = {pointer}[{place}]; "

    def spill(kind: str, element: str, names: str) -> str:
        """Write lanes to memory: reading scalars from there is 5 % faster than taking them out of registers."""
        text = "volatile {0}_t in_{2} = *({0}_t*)&{2}; const {1}* {3} = (const {1}*)&in_{2}; "
        return "".join(text.format(kind, element, name, name.upper()) for name in names)

    @wp.func_native(f"{types} {first} whole_t r = L + s; {give_whole}")
    def lane_numbers(s: int) -> whole: ...

    @wp.func_native(f"{types} whole_t r = (whole_t)s; {give_whole}")
    def spread_whole(s: int) -> whole: ...

    @wp.func_native(f"{views('', 'abc')} whole_t r = A * B + C; {give_whole}")
    def whole_fma(a: whole, b: whole, c: whole) -> whole: ...

    @wp.func_native(f"{views('', 'ab')} whole_t r = A + B; {give_whole}")
    def whole_add(a: whole, b: whole) -> whole: ...

    @wp.func_native(f"{views('', 'ab')} whole_t r = A < B ? A : B; {give_whole}")
    def whole_min(a: whole, b: whole) -> whole: ...

    @wp.func_native(f"{views('', 'ab')} whole_t r = A > B ? A : B; {give_whole}")
    def whole_max(a: whole, b: whole) -> whole: ...

    @wp.func_native(f"{views('', 'ab')} whole_t r = A >> B; {give_whole}")
    def whole_shift(a: whole, b: whole) -> whole: ...

    @wp.func_native(f"{views('', 'ab')} whole_t r = A & B; {give_whole}")
    def whole_and(a: whole, b: whole) -> whole: ...

    @wp.func_native(f"{views('', 'abcd')} whole_t r = A < B ? C : D; {give_whole}")
    def where_whole_less(a: whole, b: whole, c: whole, d: whole) -> whole: ...

    @wp.func_native(f"{views('ab', 'cd')} whole_t r = __builtin_convertvector(A < B, whole_t) ? C : D; {give_whole}")
    def whole_where_less(a: vector, b: vector, c: whole, d: whole) -> whole: ...

    @wp.func_native(
        f"{views('cd', 'ab')} typedef decltype(C < D) mask_t; "
        f"lanes_t r = __builtin_convertvector(A < B, mask_t) ? C : D; {give}"
    )
    def where_index_less(a: whole, b: whole, c: vector, d: vector) -> vector: ...

    @wp.func_native(f"{views('ab', '')} return __builtin_reduce_or(A < B) != 0;")
    def any_less(a: vector, b: vector) -> bool: ...

    @wp.func_native(f"{views('', 'ab')} return __builtin_reduce_or(A < B) != 0;")
    def any_whole_less(a: whole, b: whole) -> bool: ...

    @wp.func_native(
        f"{views('a', '')} whole_t r = __builtin_convertvector(__builtin_elementwise_floor(A), whole_t); {give_whole}"
    )
    def floor_whole(a: vector) -> whole: ...

    @wp.func_native(f"{views('', 'a')} lanes_t r = __builtin_convertvector(A, lanes_t); {give}")
    def real_of(a: whole) -> vector: ...

    @wp.func_native(gather("whole", "values.data", "K[i]") + give_whole)
    def gather_whole(values: wp.array(dtype=int), k: whole) -> whole: ...

    @wp.func_native(gather("whole", "((const int*)values.data)", "4 * K[i] + part") + give_whole)
    def gather_box(values: wp.array(dtype=wp.vec4i), k: whole, part: int) -> whole: ...

    @wp.func_native(gather("lanes", f"((const {real}*)values.data)", "2 * K[i]") + give)
    def gather_x(values: wp.array(dtype=vec2), k: whole) -> vector: ...

    @wp.func_native(gather("lanes", f"((const {real}*)values.data)", "2 * K[i] + 1") + give)
    def gather_y(values: wp.array(dtype=vec2), k: whole) -> vector: ...

    @wp.func_native(gather("lanes", f"((const {real}*)values.data)", "K[i]") + give)
    def gather_value(values: wp.array(dtype=vector), k: whole) -> vector: ...

    @wp.func_native(
        f"{views('abcd', 'k')} {real}* to = ({real}*)values.data; "
        f"{each} {{ {real}* p = to + 4 * K[i]; p[0] = A[i]; p[1] = B[i]; p[2] = C[i]; p[3] = D[i]; }}"
    )
    def scatter_vec4(values: wp.array(dtype=lanes.vec4), k: whole, a: vector, b: vector, c: vector, d: vector): ...

    @wp.func_native(
        f"{types} {spill('lanes', real, 'ab')} {spill('whole', 'int', 'jk')} {real}* to = ({real}*)values.data; "
        f"{each} {{ to[J[i]] += A[i]; to[K[i]] += B[i]; }}"
    )
    def scatter_add(values: wp.array(dtype=vector), j: whole, a: vector, k: whole, b: vector): ...

    @wp.func_native(f"{views('', 'ajk')} {each} {{ values.data[J[i]] |= A[i]; values.data[K[i]] |= A[i]; }}")
    def mark_places(values: wp.array(dtype=int), a: whole, j: whole, k: whole): ...

    @wp.func_native(f"{views('', 'jk')} {each} for (int n = J[i]; n <= K[i]; ++n) values.data[n] = 1;")
    def mark_ranges(values: wp.array(dtype=int), j: whole, k: whole): ...

    @wp.func_native(f"{views('', 'ak')} {each} if (A[i] != 0) values.data[K[i]] += A[i];")
    def scatter_steps(values: wp.array(dtype=int), k: whole, a: whole): ...

    return named(
        lane_numbers, spread_whole, whole_fma, whole_add, whole_min, whole_max, whole_shift, whole_and,
        where_whole_less, whole_where_less, where_index_less, any_less, any_whole_less, floor_whole, real_of,
        gather_whole, gather_box, gather_x, gather_y, gather_value, scatter_vec4, scatter_add, mark_places, mark_ranges,
        scatter_steps,
    )  # fmt: skip


def _scalar_functions(lanes: SimpleNamespace) -> dict[str, Any]:
    dtype, vec2, vec4 = lanes.dtype, lanes.vec2, lanes.vec4

    @wp.func
    def own(s: int):
        return s

    @wp.func
    def whole_fma(a: int, b: int, c: int):
        return a * b + c

    @wp.func
    def choose(a: Any, b: Any, c: Any, d: Any):
        return wp.where(a < b, c, d)

    @wp.func
    def is_less(a: Any, b: Any):
        return a < b

    @wp.func
    def floor_whole(a: dtype):
        return int(wp.floor(a))

    @wp.func
    def real_of(a: int):
        return dtype(a)

    @wp.func
    def gather_whole(values: wp.array(dtype=int), k: int):
        return values[k]

    @wp.func
    def gather_box(values: wp.array(dtype=wp.vec4i), k: int, part: int):
        return values[k][part]

    @wp.func
    def gather_x(values: wp.array(dtype=vec2), k: int):
        return values[k][0]

    @wp.func
    def gather_y(values: wp.array(dtype=vec2), k: int):
        return values[k][1]

    @wp.func
    def gather_value(values: wp.array(dtype=dtype), k: int):
        return values[k]

    @wp.func
    def scatter_vec4(values: wp.array(dtype=vec4), k: int, a: dtype, b: dtype, c: dtype, d: dtype):
        values[k] = vec4(a, b, c, d)

    @wp.func
    def scatter_add(values: wp.array(dtype=dtype), j: int, a: dtype, k: int, b: dtype):
        values[j] = values[j] + a
        values[k] = values[k] + b

    @wp.func
    def mark_places(values: wp.array(dtype=int), a: int, j: int, k: int):
        if a != 0:  # other threads of a GPU may mark the same places meanwhile
            wp.atomic_or(values, j, a)
            wp.atomic_or(values, k, a)

    @wp.func
    def mark_ranges(values: wp.array(dtype=int), j: int, k: int):
        for n in range(j, k + 1):
            values[n] = 1

    @wp.func
    def scatter_steps(values: wp.array(dtype=int), k: int, a: int):
        if a != 0:
            wp.atomic_add(values, k, a)

    shared = {
        "whole_add": wp.add, "whole_min": wp.min, "whole_max": wp.max, "whole_shift": wp.rshift,
        "whole_and": wp.bit_and, "where_whole_less": choose, "whole_where_less": choose, "where_index_less": choose,
        "any_less": is_less, "any_whole_less": is_less, "lane_numbers": own, "spread_whole": own,
    }  # fmt: skip
    return shared | named(
        whole_fma, floor_whole, real_of, gather_whole, gather_box, gather_x, gather_y, gather_value, scatter_vec4,
        scatter_add, mark_places, mark_ranges, scatter_steps,
    )  # fmt: skip
