"""Active waiting for a word of memory to change, in native code: what a CPU thread does between two shares of work."""

from typing import Any

import warp as wp

from warpvec.kernels.lanes import unit
from warpvec.kernels.making import made_once

# Every 32 turns the core is offered to other threads: the thread that is waited for may be queued for this core.
_WAIT = """
typedef long (*yield_core_t)();
volatile const int* word = (volatile const int*)words.data + index;
for (int turn = 0; turn < turns && *word == seen; ++turn) {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
    if (turn % 32 == 31 && yield_core) ((yield_core_t)yield_core)();
}
"""


@made_once
def make_wait() -> Any:
    """Return the kernel ``wait``, which runs on the CPU only, in one thread."""
    module = unit("thread_pool")

    @wp.func_native(_WAIT)
    def wait_while(words: wp.array(dtype=int), index: int, seen: int, turns: int, yield_core: wp.uint64): ...

    @wp.kernel(module=module)
    def wait(
        index: int,
        seen: int,
        turns: int,
        words: wp.array(dtype=int),
        yield_core: wp.uint64,  # address of a function that offers the core to other threads, or 0
    ):
        """Wait until ``words[index]`` is not ``seen``, for at most ``turns`` turns of about 35 ns each."""
        wait_while(words, index, seen, turns, yield_core)

    return wait
