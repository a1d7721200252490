"""What every participant is given and what it hands back; needs NumPy only, so that every environment can read it.

A participant is a script that is called as `script.py PROBLEM.npz RESULT VARIANT` and writes RESULT.npz (positions
of every step) and RESULT.json (times and what it says of itself). Only `advance` is timed, on the wall clock and in
CPU time: where other work shares the machine, the CPU time of a single-threaded participant still means something.
"""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FEWEST_STEPS = 3
"""Steps that a participant takes even when it is over its time."""


@dataclass(frozen=True, eq=False)
class StepProblem:
    """A clamped elastic body that falls into its sag, by implicit Euler steps.

    mesh: name or path of the mesh as Lingual loads it. nodes: rest shape [m], (node_count, 3). tets: (tet_count, 4).
    fixed: clamped nodes, (fixed_count,). young_modulus [Pa], poisson_ratio [-], density [kg/m^3].
    gravity: [m/s^2], (3,). step: h [s]. step_count: in full space; reduced_step_count: in a subspace.
    tolerance: relative residual of a step, where one can be asked for.
    budget: [s] of stepping after which no further step begins.
    basis: B, (node_count, columns), mass-orthonormal [1/sqrt(kg)]; cubature_elements: (cubature_count,);
    cubature_weights: [m^3], (cubature_count,): Lingual's subspace, for participants that take one.
    """

    mesh: str
    nodes: NDArray[np.float64]
    tets: NDArray[np.int64]
    fixed: NDArray[np.int64]
    young_modulus: float
    poisson_ratio: float
    density: float
    gravity: NDArray[np.float64]
    step: float
    step_count: int
    reduced_step_count: int
    tolerance: float
    budget: float
    basis: NDArray[np.float64]
    cubature_elements: NDArray[np.int64]
    cubature_weights: NDArray[np.float64]

    @classmethod
    def read(cls, path: str | Path) -> "StepProblem":
        with np.load(path) as stored:
            return cls(**{name: a if a.ndim else a.item() for name, a in stored.items()})

    def write(self, path: Path) -> None:
        np.savez(path, **asdict(self))

    @property
    def lame_mu(self) -> float:
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    @property
    def free(self) -> NDArray[np.int64]:
        """Nodes that move, (free_count,)."""
        return np.setdiff1d(np.arange(len(self.nodes)), self.fixed)

    @property
    def node_masses(self) -> NDArray[np.float64]:
        """Lumped mass of every node [kg], (node_count,)."""
        edges = self.nodes[self.tets[:, 1:]] - self.nodes[self.tets[:, :1]]
        shares = np.repeat(self.density * np.abs(np.linalg.det(edges)) / 24.0, 4)
        return np.bincount(self.tets.ravel(), shares, minlength=len(self.nodes))


@dataclass(frozen=True)
class Participation:
    """What a participant says of itself.

    name. version. law: constitutive law. threads: that it computes with. dof_count. note: what is special.
    reduced: whether its unknowns are those of a subspace.
    """

    name: str
    version: str
    law: str
    threads: int
    dof_count: int
    note: str
    reduced: bool = False


def arguments() -> tuple[StepProblem, Path, str]:
    """The problem, where the result goes (without suffix) and the variant, from the command line."""
    problem, result, variant = sys.argv[1:4]
    return StepProblem.read(problem), Path(result), variant


def run(
    problem: StepProblem,
    result: Path,
    participation: Participation,
    advance: Callable[[], object],
    positions: Callable[[], NDArray[np.floating]],
    reported: Callable[[], dict[str, float]] = dict,
) -> None:
    """Takes the steps and writes the result.

    advance: takes one step, the only part that is timed. positions: of all nodes after it [m], (node_count, 3).
    reported: figures that the participant has about its last step.
    """
    wall, cpu, moved, figures = [], [], [], []
    begun = time.perf_counter()
    for _ in range(problem.reduced_step_count if participation.reduced else problem.step_count):
        if len(wall) >= FEWEST_STEPS and time.perf_counter() - begun > problem.budget:
            break
        started, started_cpu = time.perf_counter(), time.process_time()
        advance()
        wall.append(1e3 * (time.perf_counter() - started))
        cpu.append(1e3 * (time.process_time() - started_cpu))
        moved.append(np.array(positions(), dtype=np.float64))
        figures.append(reported())
    np.savez(result.with_suffix(".npz"), positions=moved)
    told = {name: [step[name] for step in figures] for name in figures[0]}
    report = asdict(participation) | {"step_ms": wall, "step_cpu_ms": cpu, "reported": told}
    result.with_suffix(".json").write_text(json.dumps(report))
