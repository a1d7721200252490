"""fTetWild in a process of its own: `python -P tetwild_process.py INPUT.npz OUTPUT.npz`.

It writes a scratch file into its working folder and can end the whole process on a surface that it does not
understand, so `tetrahedralise` runs this file elsewhere and looks at how it ended. It imports nothing of the
package.
"""

import sys

import numpy as np
import pytetwild


def main(source: str, target: str) -> None:
    """Reads vertices, triangles, edge_length and envelope; writes nodes and tets."""
    with np.load(source, allow_pickle=False) as given:
        nodes, tets = pytetwild.tetrahedralize(
            given["vertices"],
            given["triangles"],
            edge_length_abs=float(given["edge_length"]),
            epsilon=float(given["envelope"]),
            num_threads=1,  # more do not make it faster
            quiet=True,
        )
    np.savez(target, nodes=nodes, tets=tets)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
