"""What every constitutive law is: three Warp functions of the deformation gradient."""

from typing import Any, NamedTuple


class MaterialTriple(NamedTuple):
    """Warp functions of one isotropic law, with p the vector of its constants (see the law's module).

    energy(F, p)      -> Psi(F)            strain energy density [Pa], zero at rest
    gradient(F, p)    -> P = dPsi/dF       first Piola-Kirchhoff stress [Pa]
    hessian(F, dF, p) -> dP = d2Psi/dF2 : dF
    principal: the Hessian is cheaper in the principal frame of F than nine times from F.
    """

    energy: Any
    gradient: Any
    hessian: Any
    principal: bool = False
