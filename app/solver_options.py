"""The choice of a solver and its options, as the command line spells them: NAME[:OPTION=VALUE,...]."""

from dataclasses import dataclass, fields, replace
from pathlib import Path

from ..model import LingualError

SOLVERS = ("reduced", "full", "modal-warping")
TOLERANCES = {"float32": 1e-5, "float64": 1e-8}
"""Relative residual of a reduced step by precision: what each can reach with room to spare."""
VOLUME_MODES = ("none", "subspace", "full")


@dataclass(frozen=True)
class SolverOptions:
    """Everything about a solver that a user may choose; options that a solver does not have are ignored.

    name: one of SOLVERS. domains: quadratic domains of the reduced solver. material: constitutive law.
    volume: how volume is corrected after a step, one of VOLUME_MODES. contact: whether the mouth's rigid
    parts push the tongue back. modes: of modal warping. train_on: recordings that the cubature and the
    pressure subspace are trained on.

    Raises LingualError for a name that there is not.
    """

    name: str = "reduced"
    domains: int = 5
    material: str = "stvk"
    volume: str = "subspace"
    contact: bool = True
    modes: int = 100
    precision: str = "float32"
    train_on: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        if self.name not in SOLVERS:
            raise LingualError(f"There is no solver '{self.name}'; choose one of {', '.join(SOLVERS)}.")
        if self.precision not in TOLERANCES:
            raise LingualError(f"There is no precision '{self.precision}'; choose one of {', '.join(TOLERANCES)}.")
        if self.volume not in VOLUME_MODES:
            raise LingualError(f"There is no volume mode '{self.volume}'; choose one of {', '.join(VOLUME_MODES)}.")

    @classmethod
    def parse(cls, text: str) -> "SolverOptions":
        """From NAME or NAME:OPTION=VALUE,OPTION=VALUE. Raises LingualError for what it does not know."""
        name, _, rest = text.partition(":")
        known = {f.name: f.default for f in fields(cls) if f.name not in ("name", "train_on")}
        given: dict[str, object] = {}
        for part in filter(None, rest.split(",")):
            option, equals, value = part.partition("=")
            if option not in known or not equals:
                raise LingualError(
                    f"'{part}' in '{text}' is not an option of a solver; write OPTION=VALUE with one of "
                    f"{', '.join(known)}."
                )
            given[option] = _read(text, option, value, known[option])
        return cls(name=name, **given)  # type: ignore[arg-type]

    def given(self, **options: object) -> "SolverOptions":
        """With those of the options that are not None."""
        return replace(self, **{k: v for k, v in options.items() if v is not None})  # type: ignore[arg-type]


def _read(text: str, option: str, value: str, default: object) -> object:
    """The value as the type of the option's default."""
    switches = {"on": True, "yes": True, "true": True, "off": False, "no": False, "false": False}
    if isinstance(default, bool):
        if value.lower() not in switches:
            raise LingualError(f"{option} in '{text}' is '{value}'; write on or off.")
        return switches[value.lower()]
    if isinstance(default, int):
        try:
            return int(value)
        except ValueError as error:
            raise LingualError(f"{option} in '{text}' is '{value}'; it must be a whole number.") from error
    return value
