"""Constitutive parameters of the tongue's tissue."""

from dataclasses import dataclass

from .errors import LingualError


@dataclass(frozen=True)
class Material:
    """Isotropic, homogeneous tissue with Rayleigh damping.

    model: which energy / gradient / Hessian triple of `kernels` is used ("stvk").
    young_modulus: E [Pa]; poisson_ratio: nu [-] (Luo 2017, section 6; Gerard et al. 2006).
    density: rho [kg/m^3].
    damping_mass [1/s], damping_stiffness [s]: Rayleigh coefficients (Luo 2017, section 8,
        after Vogt et al. 2006).

    Raises LingualError for a value outside its physical range.
    """

    model: str = "stvk"
    young_modulus: float = 6912.0
    poisson_ratio: float = 0.49
    density: float = 1000.0
    damping_mass: float = 6.22
    damping_stiffness: float = 0.11

    def __post_init__(self) -> None:
        if not self.young_modulus > 0.0:
            raise LingualError(f"Young's modulus is {self.young_modulus} Pa; it must be positive.")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise LingualError(f"Poisson's ratio is {self.poisson_ratio}; it must lie between -1 and 0.5.")
        if not self.density > 0.0:
            raise LingualError(f"Density is {self.density} kg/m^3; it must be positive.")
        if self.damping_mass < 0.0 or self.damping_stiffness < 0.0:
            raise LingualError("The Rayleigh damping coefficients must not be negative.")

    @property
    def lame_mu(self) -> float:
        """Second Lame parameter mu, the shear modulus [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter lambda [Pa]."""
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
