"""The nouns every other folder speaks in; units and frames are defined here and nowhere else.

Units: SI inside (m, kg, s, Pa); recordings, plots and reports in mm.

Head frame: x anterior (+), y left (+), z up (+), origin at the edge of the upper incisors.
Jaw frame: fixed to the mandible; it coincides with the head frame at rest. The tongue is
simulated in the jaw frame; `RigidPose` takes jaw coordinates to head coordinates.
"""

from .control import Control
from .errors import LingualError
from .history import StateHistory
from .material import Material
from .pose import RigidPose
from .reduced_model import ReducedModel
from .sensors import SENSOR_NAMES, SensorLayout
from .state import State
from .surface import EmbeddedSurface, RigidSurface
from .tet_mesh import TetMesh
from .tongue_model import TongueModel
from .trajectory import Trajectory

__all__ = [
    "SENSOR_NAMES",
    "Control",
    "EmbeddedSurface",
    "LingualError",
    "Material",
    "ReducedModel",
    "RigidPose",
    "RigidSurface",
    "SensorLayout",
    "State",
    "StateHistory",
    "TetMesh",
    "TongueModel",
    "Trajectory",
]
