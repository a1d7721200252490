"""The `lingual` command."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from .. import __version__
from ..kernels.materials import MATERIALS
from ..model import LingualError
from .play import PlayRequest, play
from .solver_options import SOLVERS, VOLUME_MODES, SolverOptions
from .terminal import console, error_console, plain_messages, stage_bars

app = typer.Typer(
    name="lingual",
    no_args_is_help=False,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

MeshOption = Annotated[
    str | None,
    typer.Option(
        "--mesh",
        metavar="NAME|PATH",
        help="Tongue to simulate: [b]head[/] (default), [b]head-small[/], [b]head-large[/], a mesh file (TetGen "
        ".node/.ele, VTK, Gmsh, ...), a closed surface (.obj, .stl, .ply), or a folder with one of them.",
    ),
]
UnitsOption = Annotated[
    str | None, typer.Option(help="Unit of the mesh file when it does not say: m, cm, mm or metres in a unit.")
]
DomainsOption = Annotated[
    int | None,
    typer.Option("--domains", min=1, help="Quadratic domains of the reduced solver: 30 unknowns each; 5 by default."),
]
TrainOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--train-on",
        metavar="FILE",
        help="Recording whose poses train the cubature (may be repeated); poses are sampled without it. Give the "
        "same to precompute and replay.",
    ),
]
MaterialOption = Annotated[
    str | None, typer.Option(metavar="|".join(MATERIALS), help="Constitutive law of the tissue; stvk by default.")
]
VolumeOption = Annotated[
    str | None,
    typer.Option(
        metavar="|".join(VOLUME_MODES), help="Correction of the volume after each step; subspace by default."
    ),
]
ContactOption = Annotated[
    bool | None, typer.Option("--contact/--no-contact", help="Whether teeth, palate and jaw hold the tongue back.")
]
SolverOption = Annotated[
    str,
    typer.Option(
        metavar="|".join(SOLVERS),
        help="[b]reduced[/]: blended quadratic domains and cubature, real time. [b]full[/]: every node, the "
        "reference. Options may follow: reduced:domains=8,volume=none.",
    ),
]
HeadlessOption = Annotated[bool, typer.Option("--headless", help="Open no window.")]
OutOption = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE|DIR",
        help="Without a window: film (.mp4, .gif), one picture (.png), or a folder for numbered pictures.",
    ),
]
ReportOption = Annotated[
    Path | None, typer.Option(metavar="FILE.json", help="Write what was measured as one JSON object.")
]
FramesOption = Annotated[int | None, typer.Option("--frames", help="Stop after so many simulated frames.")]
SizeOption = Annotated[str, typer.Option(metavar="WxH", help="Size of window and pictures in pixels.")]
ViewOption = Annotated[str, typer.Option(help="Side to look from: three-quarter, lateral, front or top.")]
FieldOption = Annotated[
    str,
    typer.Option(
        "--field",
        help="Scalar to colour the tongue by: displacement, strain energy, det F, domain, or domain weight NAME.",
    ),
]
CutOption = Annotated[bool, typer.Option("--cut", help="Cut the picture along the midsagittal plane.")]
SpeedOption = Annotated[float, typer.Option(help="Speed of a film as a factor of real time.")]
TimeOption = Annotated[
    float | None, typer.Option(help="Time of a single picture in seconds; the farthest excursion by default.")
]
BackdropOption = Annotated[str, typer.Option(help="Background: dark, light or transparent.")]
FpsOption = Annotated[float, typer.Option("--fps", help="Pictures a second of a film.")]


@app.callback(invoke_without_command=True)
def demonstrate(
    context: typer.Context,
    headless: HeadlessOption = False,
    out: OutOption = None,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Turns speech into a moving, physically simulated tongue.

    Without a command it plays the built-in demonstration: in a window, or, where there is no display,
    as a film of which it says where it is.
    """
    if version:
        console.print(f"lingual {__version__}")
    elif context.invoked_subcommand is None:
        play(PlayRequest(headless=headless, out=out))


@app.command()
def replay(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="Recording or trajectory; the built-in demonstration when left out."),
    ] = None,
    mesh: MeshOption = None,
    solver: SolverOption = "reduced",
    domains: DomainsOption = None,
    material: MaterialOption = None,
    volume: VolumeOption = None,
    contact: ContactOption = None,
    units: UnitsOption = None,
    headless: HeadlessOption = False,
    out: OutOption = None,
    frames: FramesOption = None,
    report: ReportOption = None,
    size: SizeOption = "1280x720",
    view: ViewOption = "three-quarter",
    field: FieldOption = "none",
    cut: CutOption = False,
    speed: SpeedOption = 1.0,
    time: TimeOption = None,
    backdrop: BackdropOption = "dark",
    fps: FpsOption = 50.0,
    train_on: TrainOption = None,
) -> None:
    """Moves a tongue by a recording of its sensors.

    Jaw motion is removed, the coils' paths are smoothed (Savitzky-Golay), drop-outs are bridged with a
    warning, and the tongue follows at 100 frames a second. With --headless and no --out it is only
    simulated, for --report.
    """
    options = SolverOptions.parse(solver).given(
        domains=domains, material=material, volume=volume, contact=contact, train_on=tuple(train_on or ())
    )
    pictures = (size, view, field, cut, speed, time, backdrop, fps)
    play(PlayRequest(file, mesh, options, units, headless, out, frames, report, *pictures))


@app.command()
def precompute(
    mesh: MeshOption = None,
    domains: DomainsOption = None,
    material: MaterialOption = None,
    units: UnitsOption = None,
    train_on: TrainOption = None,
) -> None:
    """Prepares a mesh for the reduced solver and caches it: weights, basis, cubature, pressures, collision points."""
    from ..precompute.cache import lingual_cache_dir
    from ..precompute.meshes.library import load_tongue
    from .wiring import contact_scene, pressure_subspace, reduced_model

    with stage_bars() as bars:
        options = SolverOptions().given(domains=domains, material=material, train_on=tuple(train_on or ()))
        tongue = load_tongue(mesh, bars, units)
        model = reduced_model(tongue, options, bars)
        pressure = pressure_subspace(model, options, bars)
        scene = contact_scene(model, options, bars)
    console.print(
        f"{tongue.name}: {model.domain_count} domains, {model.dof_count} degrees of freedom, "
        f"{len(model.cubature_elements)} of {tongue.mesh.tet_count} elements as cubature "
        f"(force error {100 * model.cubature_error:.1f} % on held-out poses), {pressure.mode_count} pressure modes, "
        f"{len(scene.points.nodes) if scene else 0} collision points. Cached in {lingual_cache_dir()}.",
        soft_wrap=True,
    )


@app.command()
def weights(
    mesh: Annotated[
        list[str] | None,
        typer.Option("--mesh", metavar="NAME|PATH", help="Tongue to study (may be repeated); head when left out."),
    ] = None,
    domains: DomainsOption = None,
    shown: Annotated[
        str,
        typer.Option(
            "--show",
            metavar="raw|blended|diffused",
            help="Weights in the picture: as in the paper, blended with the ground, or also diffused, as simulated.",
        ),
    ] = "raw",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Write the bends and the weights side by side (.png, .jpg).")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the figures as JSON.")] = None,
) -> None:
    """Compares four kinds of domain weights by what they cost a bend.

    A load-end cantilever with three domains (Luo 2017, Fig. 7) and tongues whose tip is lifted are bent in the
    subspace of each weighting and in full space, with all elements integrated.
    """
    from .weights import study

    study(mesh or ["head"], SolverOptions().given(domains=domains).domains, shown, out, json)


@app.command()
def compare(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="Recording or trajectory; the built-in demonstration when left out."),
    ] = None,
    solver: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME[:OPTION=VALUE,...]",
            help="Solver to compare, two or three times: full, reduced, modal-warping, with any of their options, such "
            "as reduced:domains=12,material=neo-hookean. full and reduced when left out.",
        ),
    ] = None,
    mesh: MeshOption = None,
    units: UnitsOption = None,
    frames: FramesOption = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for curves (PNG, SVG) and shapes side by side (PNG).")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write every figure as JSON.")] = None,
) -> None:
    """Runs two or three solvers on one trajectory and measures how far apart they are.

    Distances are from the full-space surface where there is one, from the first solver's otherwise.
    """
    from .compare import CompareRequest
    from .compare import compare as run

    run(CompareRequest(file, tuple(solver or ["full", "reduced"]), mesh, units, frames, out, json))


@app.command()
def bench(
    sizes: Annotated[
        list[str] | None,
        typer.Option("--size", metavar="small|luo|paper", help="Mesh to measure (may be repeated); all when left out."),
    ] = None,
    luo: Annotated[
        str | None,
        typer.Option(
            metavar="PATH",
            help="Mesh of Luo (2017); ../shared/data/luo_tongue when it is there, else our own head of that size.",
        ),
    ] = None,
    peers: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Figures of other programs, from benchmarks/peers/run.py.")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the figures as JSON.")] = None,
) -> None:
    """Measures every solver on this machine: small, Luo's and the paper's mesh, CPU and CUDA."""
    from .bench.command import bench as run
    from .bench.subject import SIZES

    run(sizes or SIZES, luo, peers, json)


@app.command()
def info(mesh: MeshOption = None, units: UnitsOption = None) -> None:
    """Describes a tongue mesh, this machine and the versions in use."""
    from ..precompute.meshes.library import load_tongue
    from .information import machine_table, tongue_table

    with stage_bars() as bars:
        tongue = load_tongue(mesh, bars, units)
    console.print(tongue_table(tongue))
    console.print(machine_table())


def main() -> None:
    """Runs the command; a LingualError becomes one sentence and exit code 2."""
    plain_messages()
    try:
        code = app(standalone_mode=False)  # Typer turns an interrupt into code 130
    except LingualError as error:
        error_console.print(f"[red]error:[/] {error}", soft_wrap=True)
        sys.exit(2)
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except Exception as error:
        _usage_error(error)
    if code == INTERRUPTED:
        error_console.print("Interrupted.")
    sys.exit(code or 0)


def _usage_error(error: Exception) -> None:
    """Prints what click says of wrong options and exits with its code; anything else is raised."""
    format_message = getattr(error, "format_message", None)
    if format_message is None:
        raise error
    error_console.print(f"[red]error:[/] {format_message()} Try 'lingual --help'.", soft_wrap=True)
    sys.exit(getattr(error, "exit_code", 2))
