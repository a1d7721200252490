"""The state that a solver advances; viewer and analysis read it without knowing which solver ran."""

from dataclasses import dataclass

import warp as wp


@dataclass
class State:
    """One instant of a simulated tongue, jaw frame, on the solver's device.

    time: [s].
    position: node positions [m], (node_count,) of vec3. Every solver fills it.
    velocity: node velocities [m/s], (node_count,) of vec3.
    coordinates: reduced coordinates of the displacement, (column_count, 3); empty for a solver that
        has none. Displacement of the nodes = B @ coordinates. Modal warping has (mode_count, 1, 1) scalars.
    coordinate_velocity: their rate [1/s], (column_count, 3).
    sensor_force: force that holds each sensor on its target [N], (sensor_count,) of vec3.
    """

    time: float
    position: wp.array
    velocity: wp.array
    coordinates: wp.array
    coordinate_velocity: wp.array
    sensor_force: wp.array

    def copy_from(self, other: "State") -> None:
        """Overwrites this state with `other`, without allocating."""
        self.time = other.time
        for name in ("position", "velocity", "coordinates", "coordinate_velocity", "sensor_force"):
            wp.copy(getattr(self, name), getattr(other, name))
