"""What tests share: the folder of real data, and small stand-ins for recordings and meshes."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
import warp as wp
from hypothesis import settings
from threadpoolctl import threadpool_limits

from lingual.model import EmbeddedSurface, Material, SensorLayout, TetMesh, TongueModel

settings.register_profile("lingual", deadline=None, derandomize=True)
settings.load_profile("lingual")


@pytest.fixture(scope="session", autouse=True)
def one_blas_thread():
    """On a busy machine two BLAS threads wait for each other: small factorisations take a hundred times longer."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield


@pytest.fixture(scope="session", params=["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def device(request) -> str:
    if request.param != "cpu" and not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    return request.param


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of measured meshes and recordings outside the repository; skips where it is absent."""
    folder = (Path(__file__).parents[1] / ".." / "shared" / "data").resolve()
    if not folder.is_dir():
        pytest.skip("the folder ../shared/data with measured data is absent")
    return folder


@pytest.fixture(scope="session")
def luo_rows():
    """A recording in Luo's columns [mm, x backwards, y downwards]: (300, 15), smooth, with a moving jaw."""
    t = np.arange(300)[:, None, None] / 100.0
    rest = np.array([[80.0, 115], [68, 116], [53, 120], [42, 127], [36, 136], [20, 120], [19, 138]])
    reach = np.array([[4.0, 6], [5, 7], [5, 6], [6, 7], [1, 3], [0.5, 0.5], [1, 4]])
    phase = np.arange(7)[None, :, None] * 0.4
    xy = rest + reach * np.sin(2 * np.pi * 1.5 * t + phase) * np.sin(2 * np.pi * 0.4 * t)
    return np.concatenate([np.zeros((300, 1)), xy.reshape(300, 14)], axis=1)


def luo_text(rows: np.ndarray) -> str:
    lines = [f"{len(rows)} {rows.shape[1]}"]
    lines += [" ".join(f"{value:.6f}" for value in row) + " " for row in rows]
    return "\n".join(lines) + "\n"


@pytest.fixture
def write_luo(tmp_path):
    """Function that writes rows (n, 15) as a recording and returns its path."""

    def write(rows: np.ndarray, name: str = "sentence.txt") -> Path:
        path = tmp_path / name
        path.write_text(luo_text(rows))
        return path

    return write


def kuhn_grid(divisions: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The unit cube cut into boxes and those into Kuhn's six tetrahedra: nodes (n, 3), x slowest, and tets."""
    shape = tuple(d + 1 for d in divisions)
    nodes = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(nodes)).reshape(shape)
    nx, ny, nz = divisions
    corners = np.stack([index[i : i + nx, j : j + ny, k : k + nz].ravel() for i, j, k in np.ndindex(2, 2, 2)], axis=1)
    # One tetrahedron for each order of the three axes from corner 0 to corner 7.
    tets = np.concatenate([corners[:, [0, a, a + b, 7]] for a, b, _ in permutations((4, 2, 1))])
    x = nodes[tets]
    turned = np.linalg.det(x[:, 1:] - x[:, :1]) < 0
    tets[turned] = tets[turned][:, [0, 2, 1, 3]]
    return nodes, tets


@pytest.fixture(scope="session")
def wedge():
    """A tongue-like block [mm, head axes], 80 long, 40 wide, 45 high, thin at the tip.

    Nodes (n, 3) and positively oriented tets (m, 4).
    """
    nodes, tets = kuhn_grid((8, 4, 5))
    nodes = nodes * [80.0, 40.0, 45.0] - [80.0, 20.0, 45.0]
    nodes[:, 2] *= np.interp(nodes[:, 0], [-80.0, -40.0, 0.0], [1.0, 1.0, 0.25])
    return nodes, tets


@pytest.fixture(scope="session")
def block():
    """Function that makes a box of tetrahedra, one corner at the origin: size [m], divisions -> TetMesh."""

    def make(size: tuple[float, float, float], divisions: tuple[int, int, int]) -> TetMesh:
        nodes, tets = kuhn_grid(divisions)
        return TetMesh(nodes * size, tets)

    return make


@pytest.fixture(scope="session")
def tongue_of():
    """Function that makes a tongue of a mesh held at x = 0, with a sensor on each named node."""

    def make(mesh: TetMesh, sensor_nodes: dict[str, int], material: Material | None = None) -> TongueModel:
        nodes = np.array(list(sensor_nodes.values()), dtype=int)
        return TongueModel(
            name="block",
            mesh=mesh,
            fixed_nodes=np.flatnonzero(mesh.nodes[:, 0] == 0.0),
            sensors=SensorLayout(tuple(sensor_nodes), _selection(nodes, mesh.node_count)),
            skin=EmbeddedSurface(
                np.searchsorted(mesh.boundary_nodes, mesh.boundary_triangles).astype(np.int32),
                _selection(mesh.boundary_nodes, mesh.node_count),
            ),
            material=material or Material(),
        )

    return make


def _selection(nodes: np.ndarray, node_count: int) -> sp.csr_array:
    """Sparse rows that pick the given nodes."""
    return sp.csr_array((np.ones(len(nodes)), (np.arange(len(nodes)), nodes)), shape=(len(nodes), node_count))


@pytest.fixture(scope="session")
def small_tongue(block, tongue_of) -> TongueModel:
    """A block of 180 nodes and 576 elements, 60 x 30 x 20 mm, held at its rear, sensors on its upper midline."""
    mesh = block((0.06, 0.03, 0.02), (8, 4, 3))
    top = {"TT": 0.0525, "TB": 0.0375, "TD": 0.0225, "TR": 0.015}
    at = {n: int(np.argmin(np.linalg.norm(mesh.nodes - [x, 0.015, 0.02], axis=1))) for n, x in top.items()}
    return tongue_of(mesh, at)


@pytest.fixture
def write_tetgen(tmp_path):
    """Function that writes NAME.node and NAME.ele, numbered from `first`; returns the latter's path."""

    def write(nodes: np.ndarray, tets: np.ndarray, name: str = "tongue", first: int = 0) -> Path:
        lines = [f"{len(nodes)}  3  0  0"]
        lines += [f"{i + first}  {x!r}  {y!r}  {z!r}" for i, (x, y, z) in enumerate(nodes.tolist())]
        (tmp_path / f"{name}.node").write_text("\n".join([*lines, "# a comment", ""]))
        lines = [f"{len(tets)}  4  0"]
        lines += [f"{i + first} " + " ".join(map(str, tet)) for i, tet in enumerate((tets + first).tolist())]
        (tmp_path / f"{name}.ele").write_text("\n".join([*lines, "# a comment", ""]))
        return tmp_path / f"{name}.ele"

    return write
