"""Flooding: every node belongs to one domain, each to the seed whose flood reaches it first."""

import heapq

import numpy as np
import pytest

from lingual.model import TetMesh
from lingual.precompute.partition import flooded_partition, nearest_nodes
from lingual.precompute.seeds import choose_seeds


@pytest.fixture(scope="module")
def seeds(small_tongue):
    return choose_seeds(small_tongue, 7)


@pytest.fixture(scope="module")
def partition(small_tongue, seeds):
    return flooded_partition(small_tongue.mesh, [s.nodes for s in seeds])


def test_every_node_has_a_domain_and_every_seed_its_own(small_tongue, seeds, partition):
    assert partition.shape == (small_tongue.mesh.node_count,)
    assert set(partition) == set(range(7))
    for index, seed in enumerate(seeds):
        assert set(partition[seed.nodes]) == {index}


def distances(mesh: TetMesh, sources: np.ndarray) -> np.ndarray:
    """Shortest path along edges from the nearest source, by a plain Dijkstra."""
    neighbours = [set() for _ in range(mesh.node_count)]
    for tet in mesh.tets:
        for a in tet:
            neighbours[a].update(set(tet) - {a})
    found = np.full(mesh.node_count, np.inf)
    found[sources] = 0.0
    queue = [(0.0, int(s)) for s in sources]
    while queue:
        distance, node = heapq.heappop(queue)
        if distance > found[node]:
            continue
        for other in neighbours[node]:
            further = distance + np.linalg.norm(mesh.nodes[node] - mesh.nodes[other])
            if further < found[other] - 1e-15:
                found[other] = further
                heapq.heappush(queue, (further, int(other)))
    return found


def test_a_node_belongs_to_the_seed_that_is_nearest_along_the_edges(small_tongue, seeds, partition):
    to_seed = np.array([distances(small_tongue.mesh, s.nodes) for s in seeds])
    own = to_seed[partition, np.arange(small_tongue.mesh.node_count)]
    np.testing.assert_allclose(own, to_seed.min(axis=0), atol=1e-12)


def test_every_domain_hangs_together(small_tongue, partition):
    """Within a domain all nodes are reached from one of them along edges of the domain."""
    mesh = small_tongue.mesh
    for domain in range(7):
        members = np.flatnonzero(partition == domain)
        reached = {int(members[0])}
        while True:
            touching = mesh.tets[np.isin(mesh.tets, list(reached)).any(axis=1)]
            grown = reached | (set(touching.ravel().tolist()) & set(members.tolist()))
            if grown == reached:
                break
            reached = grown
        assert reached == set(members.tolist())


def test_a_part_that_no_edge_joins_to_a_seed_goes_to_the_nearest(block):
    one = block((0.01, 0.01, 0.01), (1, 1, 1))
    nodes = np.concatenate([one.nodes, one.nodes + np.array([0.05, 0.0, 0.0])])
    two = TetMesh(nodes, np.concatenate([one.tets, one.tets + len(one.nodes)]))
    partition = flooded_partition(two, [np.array([0]), np.array([4])])
    assert set(partition[len(one.nodes) :]) == {1}


def test_the_nearest_node_of_a_node_is_itself(small_tongue):
    wanted = [3, 77, 150]
    found = nearest_nodes(small_tongue.mesh, small_tongue.mesh.nodes[wanted] + 1e-5)
    assert [nodes.tolist() for nodes in found] == [[n] for n in wanted]
