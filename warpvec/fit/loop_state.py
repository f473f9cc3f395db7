"""Which saved states of the loop a fit may continue from."""

from __future__ import annotations

from warpvec.config.fit_config import FitConfig
from warpvec.fit.record import LOSS_MAX, SECONDS_MAX
from warpvec.fit.state import State
from warpvec.fit.state_form import check_fields, field_set, fields, floats, integer, list_of, maybe, number, require


def check_loop(state: State, config: FitConfig) -> None:
    """Check what is not in the parts of ``state`` that have owners of their own.

    Raises:
        InputError: a fit with the settings ``config`` cannot have saved it.
    """
    seconds, loss = number(0.0, SECONDS_MAX), number(0.0, LOSS_MAX)
    check_fields(
        "",
        state,
        config=field_set,  # `config_from_state` compares it
        iteration=integer(1, config.iterations - 1),
        iteration_count=integer(2 if config.time_budget is not None else config.iterations, config.iterations),
        seconds=seconds,
        first_seconds=seconds,
        loss=floats(low=0.0, high=LOSS_MAX),
        best=maybe(fields(loss=loss, scene=field_set)),
        followed=maybe(field_set),
        history=list_of(field_set),
        policy=field_set,
        nodes=field_set,
        population=field_set,
    )
    require(state["iteration"] < state["iteration_count"], "iteration", "is not before the last one")
    require(state["first_seconds"] <= state["seconds"], "first_seconds", "is more than the whole time")
