"""Deferred Ctrl-C: the first sets a flag, the second is raised, and the old handler returns."""

import signal
import threading

import pytest

from warpvec.fit.interrupt import deferred_interrupts


def test_the_first_interrupt_is_deferred_and_the_second_raised():
    with deferred_interrupts() as interrupted:
        assert not interrupted()
        signal.raise_signal(signal.SIGINT)
        assert interrupted()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


class RaisesInDestructor:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)


def test_an_interrupt_in_a_destructor_is_not_lost():
    with deferred_interrupts() as interrupted:
        RaisesInDestructor()
        assert interrupted()


def test_the_callers_own_handler_stays():
    seen = []
    before = signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    try:
        with deferred_interrupts() as interrupted:
            signal.raise_signal(signal.SIGINT)
            assert not interrupted()
        assert seen == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_are_left_alone():
    found = []

    def work():
        with deferred_interrupts() as interrupted:
            found.append(interrupted())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [False]


def test_nested_blocks_share_their_flag():
    with deferred_interrupts() as outer:
        with deferred_interrupts() as inner:
            signal.raise_signal(signal.SIGINT)
            assert inner()
        assert outer()
        with deferred_interrupts() as later:
            assert later()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with deferred_interrupts() as anew:
        assert not anew()
