"""Quasi-Newton iterations of many small constrained problems at once (limited-memory BFGS).

Every tongue minimises its own incremental potential over n unknowns in the null space of the same constraints
J x = const. One iteration is `assess`, a dense product z = Z q with Z the projected inverse of an earlier
Hessian, and `propose` (Nocedal 1980; Liu, Bouaziz and Kavan 2017 use it so for elasticity). One block does one
tongue; its threads take turns along the unknowns. Nothing is read back: each tongue carries its own state, so
tongues that have converged stand still while others go on.

A proposal whose slope along the direction comes out positive has overshot: it is shortened to where the secant
of the slope vanishes instead of being accepted.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision

OVERSHOOT = 0.9
"""Share of the first slope that may come out with the opposite sign."""

STEEPEST = 1e7
"""Greatest curvature that a pair may show, in units of the inertia's, 1 / step^2: rounding can show any."""

STARTING, SEARCHING, REFUSED, CONVERGED = (wp.constant(i) for i in range(4))
"""States of one tongue: before its first trial, on its way, with a trial too long, at its minimum."""


@cache
def quasi_newton_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `assess` and `propose` of one precision."""
    scalar = precision(precision_name).scalar
    NOISE = 8.0 * {wp.float32: 1.2e-7, wp.float64: 2.2e-16}[scalar]  # relative rounding of a gradient
    vec4 = wp.types.vector(length=4, dtype=scalar)
    vector, matrix, cube = wp.array(dtype=scalar), wp.array(dtype=scalar, ndim=2), wp.array(dtype=scalar, ndim=3)
    whole = wp.array(dtype=wp.int32)

    @wp.func
    def total(partial: scalar):
        """Sum over the threads of the block, seen by all of them."""
        return wp.tile_extract(wp.tile_sum(wp.tile(partial)), 0)

    @wp.func
    def total4(partial: vec4):
        """Four sums at once: what a reduction costs is its waiting, not its adding."""
        return wp.tile_extract(wp.tile_reduce(wp.add, wp.tile(partial, preserve_type=True)), 0)

    @wp.func
    def dot(a: matrix, b: matrix, t: int, lane: int):
        partial = scalar(0.0)
        for row in range(lane, a.shape[0], wp.block_dim()):
            partial += a[row, t] * b[row, t]
        return total(partial)

    @wp.func
    def pair_dot(pairs: cube, m: int, b: matrix, t: int, lane: int):
        partial = scalar(0.0)
        for row in range(lane, b.shape[0], wp.block_dim()):
            partial += pairs[m, row, t] * b[row, t]
        return total(partial)

    @wp.kernel(module="unique")
    def assess(
        force: matrix,
        velocity: matrix,
        load: matrix,
        constraint_basis: matrix,
        step: scalar,
        damping_mass: vector,
        smallest_scale: scalar,
        tolerance: scalar,
        trial: matrix,
        direction: matrix,
        accepted_out: matrix,
        gradient_out: matrix,
        fresh_out: matrix,
        constraint_force_out: matrix,
        pair_step_out: cube,
        pair_change_out: cube,
        pair_scale_out: matrix,
        pair_share_out: matrix,
        pair_count_out: whole,
        length_out: vector,
        slope_out: vector,
        error_out: vector,
        state_out: whole,
        q_out: matrix,
    ):
        """One block accepts or shortens one tongue's trial and, when accepted, begins the two-loop recursion.

        fresh: the trial's gradient. The rows of `constraint_basis` are filled up with zeros to a multiple of four.
        constraint_force: what the constraints carry, along `constraint_basis`.
        """
        t, lane = wp.tid()
        n, kept_most = trial.shape[0], pair_step_out.shape[0]
        # Read once, before any thread of the block writes them.
        state, count = int(state_out[t]), int(pair_count_out[t])
        before, length = scalar(slope_out[t]), scalar(length_out[t])
        if state != CONVERGED:
            sizes = vec4()
            for row in range(lane, n, wp.block_dim()):
                inertia = (trial[row, t] / step - velocity[row, t]) / step
                fresh_out[row, t] = inertia + damping_mass[t] * trial[row, t] / step + force[row, t] - load[row, t]
                sizes += vec4(inertia * inertia, force[row, t] * force[row, t], scalar(0.0), scalar(0.0))
            sizes = total4(sizes)
            largest = wp.max(wp.max(sizes[0], sizes[1]), smallest_scale * smallest_scale)
            # What the constraints cannot carry: the gradient without its part along their rows, four at a time.
            for four in range(constraint_basis.shape[0] // 4):
                carried = vec4()
                for row in range(lane, n, wp.block_dim()):
                    for m in range(4):
                        carried[m] = carried[m] + constraint_basis[4 * four + m, row] * fresh_out[row, t]
                carried = total4(carried)
                if lane < 4:
                    for m in range(lane, 4, wp.block_dim()):
                        constraint_force_out[4 * four + m, t] = carried[m]
                for row in range(lane, n, wp.block_dim()):
                    along = scalar(0.0)
                    for m in range(4):
                        along += carried[m] * constraint_basis[4 * four + m, row]
                    fresh_out[row, t] = fresh_out[row, t] - along
            sums = vec4()
            for row in range(lane, n, wp.block_dim()):
                gradient = fresh_out[row, t]
                s, y = trial[row, t] - accepted_out[row, t], gradient - gradient_out[row, t]
                sums += vec4(gradient * gradient, direction[row, t] * gradient, s * y, y * y)
            sums = total4(sums)
            slope, curvature = sums[1], sums[2]
            shorter = scalar(1.0)
            if not wp.isfinite(largest) or not wp.isfinite(slope):
                shorter = scalar(0.1)
            elif state != STARTING and slope > scalar(OVERSHOOT) * wp.abs(before):
                shorter = wp.clamp(before / (before - slope), scalar(0.1), scalar(0.9))
            if shorter < scalar(1.0):
                if lane == 0:
                    length_out[t] = length * shorter
                    state_out[t] = REFUSED
            else:
                error = wp.sqrt(sums[0] / largest)
                # A pair must stand out of rounding and show no curvature that a Hessian cannot have.
                useful = state != STARTING and sums[3] > scalar(NOISE * NOISE) * largest
                useful = useful and scalar(STEEPEST) * curvature > step * step * sums[3]
                newest = count % kept_most
                for row in range(lane, n, wp.block_dim()):
                    gradient = fresh_out[row, t]
                    if useful:
                        pair_step_out[newest, row, t] = trial[row, t] - accepted_out[row, t]
                        pair_change_out[newest, row, t] = gradient - gradient_out[row, t]
                    accepted_out[row, t] = trial[row, t]
                    gradient_out[row, t] = gradient
                    q_out[row, t] = -gradient
                scale = scalar(0.0)
                if useful:
                    scale = scalar(1.0) / curvature
                    count += 1
                if lane == 0:
                    if useful:
                        pair_scale_out[newest, t] = scale
                    pair_count_out[t] = count
                    error_out[t] = error
                    length_out[t] = scalar(1.0)
                    state_out[t] = SEARCHING
                    if error <= tolerance:
                        state_out[t] = CONVERGED
                if error > tolerance:
                    for back in range(wp.min(count, kept_most)):
                        m = (count - 1 - back) % kept_most
                        if back > 0 or not useful:
                            scale = pair_scale_out[m, t]
                        share = pair_dot(pair_step_out, m, q_out, t, lane) * scale
                        if lane == 0:
                            pair_share_out[m, t] = share
                        for row in range(lane, n, wp.block_dim()):
                            q_out[row, t] = q_out[row, t] - share * pair_change_out[m, row, t]

    @wp.kernel(module="unique")
    def propose(
        z: matrix,
        accepted: matrix,
        gradient: matrix,
        pair_step: cube,
        pair_change: cube,
        pair_scale: matrix,
        pair_share: matrix,
        pair_count: whole,
        length: vector,
        state: whole,
        z_out: matrix,
        direction_out: matrix,
        slope_out: vector,
        trial_out: matrix,
    ):
        """One block ends one tongue's recursion and writes its next trial."""
        t, lane = wp.tid()
        n = z.shape[0]
        if state[t] == SEARCHING:
            count = pair_count[t]
            kept = wp.min(count, pair_step.shape[0])
            for forth in range(kept):
                m = (count - kept + forth) % pair_step.shape[0]
                share = pair_share[m, t] - pair_scale[m, t] * pair_dot(pair_change, m, z_out, t, lane)
                for row in range(lane, n, wp.block_dim()):
                    z_out[row, t] = z_out[row, t] + share * pair_step[m, row, t]
            for row in range(lane, n, wp.block_dim()):
                direction_out[row, t] = z_out[row, t]
            slope = dot(direction_out, gradient, t, lane)
            if lane == 0:
                slope_out[t] = slope
        for row in range(lane, n, wp.block_dim()):
            if state[t] == CONVERGED:
                trial_out[row, t] = accepted[row, t]
            else:
                trial_out[row, t] = accepted[row, t] + length[t] * direction_out[row, t]

    return SimpleNamespace(assess=assess, propose=propose)
