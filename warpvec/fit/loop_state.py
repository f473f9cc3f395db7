"""Which saved states of the loop a fit may continue from."""

from __future__ import annotations

from warpvec.config.fit_config import FitConfig
from warpvec.fit.record import LOSS_MAX, SECONDS_MAX
from warpvec.fit.state import State
from warpvec.fit.state_form import Fields, FieldSet, Integer, ListOf, Maybe, Number, check_fields, floats, require


def check_loop(state: State, config: FitConfig) -> None:
    """Check what is not in the parts of ``state`` that have owners of their own.

    Raises:
        InputError: a fit with the settings ``config`` cannot have saved it.
    """
    seconds, loss = Number(0.0, SECONDS_MAX), Number(0.0, LOSS_MAX)
    check_fields(
        "",
        state,
        config=FieldSet(),  # `config_from_state` compares it
        iteration=Integer(1, config.iterations - 1),
        iteration_count=Integer(2 if config.time_budget is not None else config.iterations, config.iterations),
        seconds=seconds,
        first_seconds=seconds,
        loss=floats(low=0.0, high=LOSS_MAX),
        best=Maybe(Fields({"loss": loss, "scene": FieldSet()})),
        followed=Maybe(FieldSet()),
        history=ListOf(FieldSet()),
        policy=FieldSet(),
        nodes=FieldSet(),
        population=FieldSet(),
    )
    require(state["iteration"] < state["iteration_count"], "iteration", "is not before the last one")
    require(state["first_seconds"] <= state["seconds"], "first_seconds", "is more than the whole time")
