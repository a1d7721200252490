"""Lingual beside other solvers of soft bodies: same mesh, material, load and step, in one run.

    python benchmarks/peers/run.py [--sizes small luo paper] [--json FILE]

A tongue, clamped at its bones, falls into its sag under gravity: StVK (or the law that a peer has), implicit Euler,
h = 10 ms, from rest, no damping. The peers are installed once in benchmarks/peers/.venv from requirements.txt; every
participant is a process of its own with one thread, and Lingual runs again after each peer. The JSON is
{size: {peer: ms a step}} with everything else under "details", as `lingual bench --peers FILE` reads it.
What can be compared with what is in docs/design/peers.md.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from accuracy import deviation, relative_residual
from environment import HERE, last_line, prepare, python
from lingual_solvers import REFERENCE
from step_problem import StepProblem

from lingual.app.bench.command import machine
from lingual.app.bench.subject import SIZES, mesh_of
from lingual.app.solver_options import SolverOptions
from lingual.app.wiring import reduced_model
from lingual.precompute.meshes.library import load_tongue

GRAVITY = (0.0, 0.0, -9.81)
STEP = 0.01
TOLERANCE = 1e-5
EQUAL_ACCURACY = 0.02
"""Deviation of the nodes from the converged full-space solution of the same law up to which times are comparable."""
REDUCED_STEPS = 200
"""The fall, which is compared, and what follows: a reduced step is short and few would be measured."""
WARM_UP_STEPS = 1
TIME_LIMIT = 900.0
"""[s] for one participant, its preparation included."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Participant:
    """script and variant, whether full space or reduced, and the sizes that it takes part in."""

    script: str
    variant: str
    kind: str
    sizes: tuple[str, ...] = SIZES

    @property
    def label(self) -> str:
        return f"{self.script.removesuffix('.py')} {self.variant}"


OURS = {kind: Participant("lingual_solvers.py", kind, kind) for kind in ("full", "reduced")}
PEERS = (
    Participant("scikit_fem.py", "pardiso", "full"),
    Participant("simkit_stvk.py", "full", "full"),
    Participant("mujoco_flex.py", "full-100", "full"),
    Participant("mujoco_flex.py", "full-2000", "full"),
    Participant("newton_soft_body.py", "vbd-10", "full"),
    Participant("newton_soft_body.py", "vbd-100", "full"),
    Participant("newton_soft_body.py", "vbd-1000", "full"),
    Participant("newton_soft_body.py", "vbd-5000", "full", ("small",)),
    Participant("newton_soft_body.py", "xpbd-300", "full"),
    Participant("simkit_stvk.py", "reduced", "reduced"),
    Participant("mujoco_flex.py", "quadratic-100", "reduced"),
    Participant("mujoco_flex.py", "quadratic-2000", "reduced"),
)
LAWS = ("stvk", "neo-hookean")
"""Of the references; a peer of neither is held to StVK."""

Result = dict[str, object]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", nargs="+", default=list(SIZES), choices=SIZES)
    parser.add_argument("--steps", type=int, default=10, help="in full space; a participant takes 3 at least")
    parser.add_argument("--budget", type=float, default=25.0, help="seconds after which it takes no further step")
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()
    failed = prepare()
    for line, reason in failed.items():
        print(f"not installed: {line} ({reason})")
    details: dict[str, object] = {
        "machine": machine(),
        "not_installed": failed,
        "step_s": STEP,
        "gravity": GRAVITY,
        "tolerance": TOLERANCE,
    }
    written: dict[str, object] = {"details": details}
    for size in arguments.sizes:
        problem = export(size, arguments.steps, arguments.budget)
        results = measure(problem, size)
        details[size] = measured = {
            "node_count": len(problem.nodes),
            "tet_count": len(problem.tets),
            "load_average": os.getloadavg(),
            "participants": results,
        }
        written[size] = {peer_name(r): r["ms_per_step"] for r in results if "ratio" in r}
        print_table(size, measured)
        if arguments.json:  # what has been measured is kept when a later size is interrupted
            arguments.json.write_text(json.dumps(written, indent=1))


def export(size: str, steps: int, budget: float) -> StepProblem:
    """The problem of one size, with our subspace of 150 degrees of freedom."""
    mesh = mesh_of(size, None)
    tongue = load_tongue(mesh)
    model, material = reduced_model(tongue, SolverOptions()), tongue.material
    return StepProblem(
        mesh=mesh or "",
        nodes=tongue.mesh.nodes,
        tets=tongue.mesh.tets.astype(np.int64),
        fixed=tongue.fixed_nodes,
        young_modulus=material.young_modulus,
        poisson_ratio=material.poisson_ratio,
        density=material.density,
        gravity=np.array(GRAVITY),
        step=STEP,
        step_count=steps,
        reduced_step_count=REDUCED_STEPS,
        tolerance=TOLERANCE,
        budget=budget,
        basis=model.basis,
        cubature_elements=model.cubature_elements,
        cubature_weights=model.cubature_weights,
    )


def measure(problem: StepProblem, size: str) -> list[Result]:
    """Results of Lingual, first, and of every peer; Lingual's times are pooled over its runs between the peers."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        problem.write(folder / "problem.npz")
        references = {}
        for law in LAWS:
            participate(Participant("lingual_solvers.py", REFERENCE + law, "full"), folder)
            references[law] = positions_of(folder, REFERENCE + law)
        ours: dict[str, list[Result]] = {kind: [] for kind in OURS}
        peers = []
        for peer in PEERS:
            if size in peer.sizes:
                peers.append(judged(problem, participate(peer, folder), references, folder, peer))
                own = OURS[peer.kind]
                ours[peer.kind].append(judged(problem, participate(own, folder), references, folder, own))
    own_results = [pooled(runs, problem.step_count) for runs in ours.values()]
    for result in peers:
        own = [run for run in ours[str(result["kind"])] if "failed" not in run]
        if own and "failed" not in result:  # CPU time, as all have one thread, and of the steps that both took
            same_steps = medians(own, min(result["steps_taken"], problem.step_count))
            result["ratio"] = result["cpu_ms_per_step"] / same_steps["cpu_ms_per_step"]
    return own_results + peers


def participate(participant: Participant, folder: Path) -> Result:
    """Runs one participant in a process of its own; its report, or why there is none."""
    interpreter = sys.executable if participant.script == "lingual_solvers.py" else str(python())
    result = folder / participant.variant
    command = [interpreter, "-W", "ignore", str(HERE / participant.script)]
    command += [str(folder / "problem.npz"), str(result), participant.variant]
    # Lingual looks for its mesh and its warnings of a path relative to here; the others write logs where they run.
    place = None if participant.script == "lingual_solvers.py" else folder
    environment = os.environ | ONE_THREAD
    print(f"  {participant.label} ...", end="", flush=True)
    try:
        done = subprocess.run(
            command, cwd=place, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        print(f" stopped after {TIME_LIMIT:.0f} s")
        return {"name": participant.label, "failed": f"not ready within {TIME_LIMIT:.0f} s"}
    if done.returncode:
        print(f" failed: {last_line(done.stderr)}")
        return {"name": participant.label, "failed": last_line(done.stderr)}
    report: Result = json.loads(result.with_suffix(".json").read_text())
    print(f" {np.median(report['step_ms'][WARM_UP_STEPS:]):.3g} ms")
    return report


def positions_of(folder: Path, variant: str) -> np.ndarray:
    """Of every step that was taken [m], (step_count, node_count, 3)."""
    path = (folder / variant).with_suffix(".npz")
    if not path.is_file():
        raise SystemExit(f"The {variant} was not computed; the peers cannot be judged without it.")
    with np.load(path) as stored:
        return stored["positions"]


def judged(
    problem: StepProblem, report: Result, references: dict[str, np.ndarray], folder: Path, participant: Participant
) -> Result:
    """The report with medians, deviation from the reference of its law and, for StVK in full space, its residual."""
    result = report | {"kind": participant.kind}
    if "failed" in report:
        return result
    positions = positions_of(folder, participant.variant)
    result |= medians([report], problem.step_count)
    result["steps_taken"] = len(positions)
    result |= deviation(problem, positions, references.get(str(report["law"]), references["stvk"]))
    result["equal_accuracy"] = bool(result["node_deviation"] <= EQUAL_ACCURACY)
    if participant.kind == "full" and report["law"] == "stvk":
        result["relative_residual"] = relative_residual(problem, positions)
    return result


def medians(runs: list[Result], step_count: int) -> Result:
    """Median times over the first `step_count` steps of all runs, the fall, and over all of their steps."""

    def median(times: str, last: int | None) -> float:
        return float(np.median([time for run in runs for time in run[times][WARM_UP_STEPS:last]]))

    return {
        "ms_per_step": median("step_ms", step_count),
        "cpu_ms_per_step": median("step_cpu_ms", step_count),
        "all_steps_ms": median("step_ms", None),
    }


def pooled(runs: list[Result], step_count: int) -> Result:
    """One result of several runs of the same participant, with the medians of all of them."""
    measured = [run for run in runs if "failed" not in run]
    if not measured:
        return runs[0]
    every = {"step_ms_of_runs": [run["step_ms"] for run in measured]}
    return measured[-1] | every | medians(measured, step_count)


def peer_name(result: Result) -> str:
    """The peer's name, with how far its nodes are off where that makes its time incomparable."""
    if result["equal_accuracy"]:
        return str(result["name"])
    return f"{result['name']} ({100.0 * result['node_deviation']:.0f} % off)"


def print_table(size: str, measured: Result) -> None:
    """measured: node_count, tet_count and participants of one size."""
    print(f"\n{size}: {measured['node_count']:,} nodes, {measured['tet_count']:,} tetrahedra")
    print("| solver | law | DOFs | steps | ms a step | CPU ms | ms, all | to Lingual | tip mm | off % | residual |")
    print("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    for r in measured["participants"]:
        if "failed" in r:
            print(f"| {r['name']} | {r['failed']} |")
            continue
        ratio = f"{r['ratio']:.2f} x" if "ratio" in r else ""
        later = f"{r['all_steps_ms']:.3g}" if r["reduced"] else ""
        residual = f"{r['relative_residual']:.1e}" if "relative_residual" in r else ""
        print(
            f"| {r['name']} | {r['law']} | {r['dof_count']:,} | {r['steps_taken']} | {r['ms_per_step']:.4g} "
            f"| {r['cpu_ms_per_step']:.4g} | {later} | {ratio} | {r['tip_mm']:.3f} | {_percent(r['node_deviation'])} "
            f"| {residual} |"
        )
    print()


def _percent(share: float) -> str:
    return "< 0.01" if share < 1e-4 else f"{100.0 * share:.3g}" if share < 10.0 else f"{100.0 * share:,.0f}"


if __name__ == "__main__":
    main()
