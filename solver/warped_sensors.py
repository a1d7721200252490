"""Where a modally warped shape carries the sensors, and how that depends on the modal coordinates.

Sensor s is at its rest position plus the sum over the nodes n under it of weight_sn Rbar(w_n) a_n, with
a = Phi q and w = Psi q, Psi = W Phi (Choi and Ko 2005). Only the rows of the nodes under sensors are used,
in double precision: a dozen nodes instead of thousands.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.modal_warping import modal_warping_kernels
from ..model.modal_model import ModalModel


class WarpedSensors:
    """Evaluates sensor displacements and their Jacobian; both are overwritten by the next evaluation.

    displacement: (3 sensor_count,) float64 [m]. jacobian: (3 sensor_count, mode_count) float64, row 3 s + i.
    """

    def __init__(self, model: ModalModel) -> None:
        sensors = model.tongue.sensors
        under = int(np.diff(sensors.weights.indptr).max(initial=1))
        weights = np.zeros((sensors.count, under))  # filled up with zeros where fewer nodes are under a sensor
        nodes = np.zeros((sensors.count, under), dtype=np.int64)
        for s in range(sensors.count):
            footprint = sensors.footprint(s)
            nodes[s, : len(footprint)] = footprint
            weights[s, : len(footprint)] = sensors.weights.data[sensors.weights.indptr[s] :][: len(footprint)]
        rows = model.warping_rows(nodes.ravel())
        self._rows = rows.reshape(-1, model.mode_count)
        self._rows_of_sensor = rows.reshape(sensors.count, 6 * under, model.mode_count)

        def zeros(*shape: int) -> wp.array:
            return wp.zeros(shape, dtype=wp.float64, device="cpu")

        linear, displacement = zeros(2 * nodes.size, 3, 1), zeros(sensors.count, 3, 1)
        slope = zeros(sensors.count, 3, 6 * under, 1)
        self._launch = wp.launch(
            modal_warping_kernels("float64").sensor_warp,
            (sensors.count, 1),
            [linear, wp.array(weights, dtype=wp.float64, device="cpu")],
            [displacement, slope],
            device="cpu",
            record_cmd=True,
        )
        # Zero-copy NumPy views of the Warp arrays.
        self._linear = linear.numpy().reshape(-1)
        self._slope = slope.numpy()[..., 0]
        self.displacement = displacement.numpy().reshape(-1)
        self._jacobian = np.empty((sensors.count, 3, model.mode_count))
        self.jacobian = self._jacobian.reshape(-1, model.mode_count)
        self._coordinates = np.full(model.mode_count, np.nan)

    def evaluate(self, coordinates: NDArray[np.float64]) -> None:
        """Fills `displacement` and `jacobian` for modal coordinates (mode_count,).

        A step starts where the one before ended, so that place is not evaluated twice.
        """
        if np.array_equal(coordinates, self._coordinates):
            return
        self._coordinates[:] = coordinates
        np.dot(self._rows, coordinates, out=self._linear)
        self._launch.launch()
        np.matmul(self._slope, self._rows_of_sensor, out=self._jacobian)
