"""Time of every kernel on every device Warp finds, at the size of the paper's mesh.

    python benchmarks/kernels.py

800 cubature elements and 50 columns for the reduced kernels, 56,794 elements and 11,083 nodes for the
full-space ones; 200 launches after a warm-up, synchronised once. The tables are random: only times matter.
"""

import time

import numpy as np
import warp as wp

from lingual.kernels.elasticity import elasticity_kernels
from lingual.kernels.full_space import full_space_kernels
from lingual.kernels.precision import precision
from lingual.kernels.reduced import reduced_kernels

ELEMENTS, COLUMNS, TETS, NODES = 800, 50, 56_794, 11_083
LAUNCHES = 200


def main() -> None:
    for device in wp.get_devices():
        print(f"{device.alias}: {device.name}")
        for name in ("float64", "float32"):
            for label, launch in _launches(name, str(device)).items():
                print(f"  {name}  {label:<34} {_milliseconds(launch, str(device)):9.4f} ms", flush=True)


def _milliseconds(launch, device: str) -> float:
    launch()
    wp.synchronize_device(device)
    started = time.perf_counter()
    for _ in range(LAUNCHES):
        launch()
    wp.synchronize_device(device)
    return 1e3 * (time.perf_counter() - started) / LAUNCHES


def _launches(name: str, device: str) -> dict:
    p, rng = precision(name), np.random.default_rng(0)
    elastic, full, reduced = elasticity_kernels("stvk", name), full_space_kernels(name), reduced_kernels(name)

    def random(*shape: int, dtype) -> wp.array:
        return wp.array(0.1 * rng.standard_normal(shape), dtype=dtype, device=device)

    def zeros(*shape: int, dtype) -> wp.array:
        return wp.zeros(shape, dtype=dtype, device=device)

    def launcher(kernel, dim, inputs, outputs):
        return lambda: wp.launch(kernel, dim, inputs, outputs, device=device)

    material = p.parameters(2319.0, 113651.0, 0.0, 0.0, 0.0, 0.0)
    result = {}
    for count, size in ((ELEMENTS, f"{ELEMENTS} elements"), (TETS, f"{TETS} elements")):
        gradient = random(count, 3, 3, dtype=p.mat33)
        weight = zeros(count, dtype=p.scalar)
        inputs = [gradient, gradient, weight, material, material, p.scalar(11.0)]
        stress, tangent = zeros(count, dtype=p.mat33), zeros(count, 3, 3, dtype=p.mat33)
        result[f"stress, {size}"] = launcher(elastic.stress, count, inputs, [stress])
        result[f"tangent, {size}"] = launcher(elastic.tangent, count, inputs, [tangent])
    H = random(3 * ELEMENTS, COLUMNS, dtype=p.scalar)
    Q, out = random(COLUMNS, 3, dtype=p.vec3), zeros(ELEMENTS, dtype=p.mat33)
    tangent = zeros(ELEMENTS, 3, 3, dtype=p.mat33)
    product = zeros(3 * ELEMENTS, 6, COLUMNS, dtype=p.scalar)
    blocks = zeros(COLUMNS, 6, COLUMNS, dtype=p.scalar)
    B, rest = random(NODES, COLUMNS, dtype=p.scalar), random(NODES, 3, dtype=p.vec3)
    skin = zeros(NODES, dtype=p.vec3)
    result["reduced gradient"] = launcher(reduced.gradient, ELEMENTS, [H, Q], [out])
    result["reduced force"] = launcher(reduced.force, COLUMNS, [H, out], [zeros(COLUMNS, dtype=p.vec3)])
    result["tangent times gradient"] = launcher(
        reduced.tangent_times_gradient, (ELEMENTS, COLUMNS), [H, tangent], [product]
    )
    result["reduced stiffness"] = launcher(reduced.stiffness, (COLUMNS, 6, COLUMNS), [H, product], [blocks])
    result["skin, 11,083 vertices"] = launcher(reduced.skin, NODES, [rest, B, Q], [skin])
    tets = wp.array(rng.integers(0, NODES, (TETS, 4)), dtype=wp.int32, device=device)
    shape_gradients = random(TETS, 4, 3, dtype=p.vec3)
    result["displacement gradient, all elements"] = launcher(
        full.displacement_gradient, TETS, [skin, tets, shape_gradients], [zeros(TETS, dtype=p.mat33)]
    )
    starts = wp.array(np.linspace(0, 4 * TETS, NODES + 1).astype(np.int32), device=device)
    corners = wp.array(rng.permutation(4 * TETS).astype(np.int32), device=device)
    stress = zeros(TETS, dtype=p.mat33)
    result["gather force, all elements"] = launcher(
        full.gather_force, NODES, [stress, shape_gradients, starts, corners], [zeros(NODES, dtype=p.vec3)]
    )
    return result


if __name__ == "__main__":
    main()
