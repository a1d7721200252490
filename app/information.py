"""Tables for `lingual info`."""

import os
import platform
from importlib.metadata import version

import numpy as np
import warp as wp
from rich.table import Table

from .. import __version__
from ..model import TongueModel
from ..model.units import MM_PER_M
from ..precompute.cache import lingual_cache_dir


def tongue_table(tongue: TongueModel) -> Table:
    """Sizes, volume, attachment and sensors of a tongue, lengths in mm."""
    mesh = tongue.mesh
    extent = MM_PER_M * np.ptp(mesh.nodes, axis=0)
    table = Table(title=tongue.name, show_header=False)
    table.add_row("nodes, tetrahedra", f"{mesh.node_count:,}, {mesh.tet_count:,}")
    table.add_row("extent x, y, z", " x ".join(f"{e:.1f}" for e in extent) + " mm")
    table.add_row("volume", f"{mesh.volume * MM_PER_M**3 / 1e3:.1f} cm^3")
    table.add_row("fixed nodes", f"{len(tongue.fixed_nodes):,}")
    table.add_row("skin", f"{tongue.skin.vertex_count:,} vertices, {len(tongue.skin.triangles):,} triangles")
    table.add_row("rigid parts", ", ".join(part.name for part in tongue.rigid) or "none")
    for name, position in zip(tongue.sensors.names, MM_PER_M * tongue.sensor_rest_positions, strict=True):
        table.add_row(f"sensor {name}", "x {:.1f}, y {:.1f}, z {:.1f} mm".format(*position))
    material = tongue.material
    table.add_row(
        "material",
        f"{material.model}, E {material.young_modulus:g} Pa, nu {material.poisson_ratio:g}, "
        f"rho {material.density:g} kg/m^3",
    )
    return table


def machine_table() -> Table:
    """Versions and devices."""
    table = Table(title="This machine", show_header=False)
    table.add_row("lingual", __version__)
    table.add_row("Python", f"{platform.python_version()} on {platform.system()} {platform.machine()}")
    table.add_row("cores", str(os.cpu_count()))
    for package in ("warp-lang", "numpy", "scipy", "moderngl", "imgui-bundle"):
        table.add_row(package, version(package))
    table.add_row("Warp devices", ", ".join(f"{d.alias} ({d.name})" for d in wp.get_devices()))
    table.add_row("cache", str(lingual_cache_dir()))
    return table
