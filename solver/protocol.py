"""What every solver offers; viewer, analysis and comparisons do not know which one runs."""

from dataclasses import dataclass
from typing import Protocol

from ..model import Control, State, TongueModel


@dataclass
class StepReport:
    """What happened in the last step.

    iterations: Newton iterations. residual: relative residual reached. converged: residual at or below
    the tolerance. substeps: 1, or more when the step was retried with smaller ones.
    """

    iterations: int = 0
    residual: float = 0.0
    converged: bool = True
    substeps: int = 1


class Solver(Protocol):
    """Advances a tongue by one time step.

    name: as reports and the command line call it. tongue: what is simulated. dof_count: unknowns of
    one step. report: of the last step. volume_mode: how it corrects volume after a step ("none", "subspace",
    "full"). contact_point_count: surface points at which it looks for contact.
    """

    name: str
    tongue: TongueModel
    report: StepReport

    @property
    def dof_count(self) -> int: ...

    @property
    def volume_mode(self) -> str: ...

    @property
    def contact_point_count(self) -> int: ...

    def new_state(self) -> State:
        """A state at rest at time 0, with arrays on the solver's device."""
        ...

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        """Fills `state_out` with the state `dt` seconds after `state_in`; they may not be the same object.

        Does not raise when Newton's method fails to converge: `report.converged` says so.
        """
        ...
