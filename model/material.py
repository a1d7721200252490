"""Constitutive parameters of the tongue's tissue."""

from dataclasses import dataclass

from ..kernels.materials import MATERIALS, pack_parameters
from .errors import LingualError


@dataclass(frozen=True)
class Material:
    """Isotropic, homogeneous tissue with Rayleigh damping. The defaults are each law's published tongue.

    model: the constitutive law, one of `kernels.materials.MATERIALS`; `replace(material, model=name)` keeps the
        rest. docs/design/materials.md tells what each law takes and where its values come from.
    young_modulus: E [Pa]; poisson_ratio: nu [-], of stvk, neo-hookean and corotational (Luo 2017, section 6).
    mooney_rivlin: (C10, C01, C11, C20, C02) [Pa], bulk_modulus: kappa [Pa], of mooney-rivlin
        (Buchaillard et al. 2009; kappa = 100 C10, a Poisson's ratio of 0.49).
    density: rho [kg/m^3].
    damping_mass [1/s], damping_stiffness [s]: Rayleigh coefficients (Luo 2017, section 8,
        after Vogt et al. 2006), with the stiffness at rest.

    Raises LingualError for a law that there is not and for a value outside its physical range.
    """

    model: str = "stvk"
    young_modulus: float = 6912.0
    poisson_ratio: float = 0.49
    density: float = 1000.0
    damping_mass: float = 6.22
    damping_stiffness: float = 0.11
    mooney_rivlin: tuple[float, float, float, float, float] = (1037.0, 0.0, 0.0, 486.0, 0.0)
    bulk_modulus: float = 103700.0

    def __post_init__(self) -> None:
        if self.model not in MATERIALS:
            raise LingualError(f"There is no material '{self.model}'; choose one of {', '.join(MATERIALS)}.")
        if not self.young_modulus > 0.0:
            raise LingualError(f"Young's modulus is {self.young_modulus} Pa; it must be positive.")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise LingualError(f"Poisson's ratio is {self.poisson_ratio}; it must lie between -1 and 0.5.")
        if len(self.mooney_rivlin) != 5 or not self.mooney_rivlin[0] + self.mooney_rivlin[1] > 0.0:
            raise LingualError(
                f"The Mooney-Rivlin constants are {self.mooney_rivlin} Pa; give C10, C01, C11, C20 and C02 with "
                "C10 + C01, half the shear modulus, positive."
            )
        if not self.bulk_modulus > 0.0:
            raise LingualError(f"The bulk modulus is {self.bulk_modulus} Pa; it must be positive.")
        if not self.density > 0.0:
            raise LingualError(f"Density is {self.density} kg/m^3; it must be positive.")
        if self.damping_mass < 0.0 or self.damping_stiffness < 0.0:
            raise LingualError("The Rayleigh damping coefficients must not be negative.")

    @property
    def lame_mu(self) -> float:
        """Second Lame parameter mu, the shear modulus [Pa], at small strain."""
        if self.model == "mooney-rivlin":
            return 2.0 * (self.mooney_rivlin[0] + self.mooney_rivlin[1])
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter lambda [Pa], at small strain."""
        if self.model == "mooney-rivlin":
            return self.bulk_modulus - 2.0 / 3.0 * self.lame_mu
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    @property
    def elastic_parameters(self) -> list[float]:
        """The law's constants as the kernels take them [Pa], PARAMETER_COUNT long."""
        if self.model == "mooney-rivlin":
            return pack_parameters(self.model, *self.mooney_rivlin, self.bulk_modulus)
        return pack_parameters(self.model, self.lame_mu, self.lame_lambda)

    @property
    def viscous_parameters(self) -> list[float]:
        """(mu, lambda) at small strain [Pa] as the kernels' viscosity takes them, PARAMETER_COUNT long."""
        return [self.lame_mu, self.lame_lambda, *([0.0] * (len(self.elastic_parameters) - 2))]
