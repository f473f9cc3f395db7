"""Waiting for a word of memory to change, outside Python: what a CPU thread does between two shares of work."""

from functools import cache
from typing import Any

import warp as wp

# The core is offered to others now and then: whoever is waited for may be queued for this very one.
_WAIT = """
typedef long (*give_way_t)();
volatile const int* word = (volatile const int*)words.data + index;
for (int turn = 0; turn < turns && *word == seen; ++turn) {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
    if (turn % 32 == 31 && give_way) ((give_way_t)give_way)();
}
"""


@cache
def make_wait() -> Any:
    """The kernel ``wait``, of one thread and of the CPU alone."""
    module = wp.get_module("warpvec.kernels.thread_pool")
    module.options.update(enable_backward=False)

    @wp.func_native(_WAIT)
    def wait_while(words: wp.array(dtype=int), index: int, seen: int, turns: int, give_way: wp.uint64): ...

    @wp.kernel(module=module)
    def wait(
        index: int,
        seen: int,
        turns: int,
        words: wp.array(dtype=int),
        give_way: wp.uint64,  # address of a function that offers the core to others, or 0
    ):
        """Until ``words[index]`` is not ``seen``, or for so many turns, of some 35 ns each."""
        wait_while(words, index, seen, turns, give_way)

    return wait
