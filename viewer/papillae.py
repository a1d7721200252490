"""A small tiling 3D texture of bumps the size of the tongue's papillae.

Sampled at rest positions it sticks to the tissue as it deforms, needs no unwrapping, and one fetch
gives both the height and its gradient.
"""

import moderngl
import numpy as np
from numpy.typing import NDArray

TILE = 0.0052
"""Side of the cube that repeats [m]."""

_SIZE = 48
_COUNT = 343  # papillae in the cube: about 0.74 mm apart


def _scattered_points() -> NDArray[np.float64]:
    """Points spread evenly but without rows in a periodic unit cube (Mitchell 1991), (_COUNT, 3)."""
    rng = np.random.default_rng(7)
    points = rng.random((_COUNT, 3))
    for i in range(1, _COUNT):
        candidates = rng.random((24, 3))
        apart = np.abs(candidates[:, None] - points[:i])
        apart = np.minimum(apart, 1.0 - apart)
        nearest = np.einsum("cpk,cpk->cp", apart, apart).min(axis=1)
        points[i] = candidates[np.argmax(nearest)]
    return points


def papillae_volume() -> NDArray[np.uint8]:
    """Gradient (0.5 is zero) and height of the bumps, (size, size, size, 4) bytes; axes z, y, x.

    Rounded bumps around scattered points, laid down by periodic convolution.
    """
    centres = _SIZE * _scattered_points()
    rng = np.random.default_rng(8)
    spikes = np.zeros((_SIZE, _SIZE, _SIZE))
    np.add.at(spikes, tuple(centres.astype(int).T % _SIZE), 0.75 + 0.5 * rng.random(len(centres)))
    frequency = np.fft.fftfreq(_SIZE)
    squared = sum(f**2 for f in np.meshgrid(frequency, frequency, frequency, indexing="ij"))
    sigma = 0.24 * _SIZE / _COUNT ** (1 / 3)
    height = np.fft.ifftn(np.fft.fftn(spikes) * np.exp(-2.0 * np.pi**2 * sigma**2 * squared)).real
    height = np.sqrt(np.clip(height / np.quantile(height, 0.995), 0.0, 1.0))
    gradient = np.stack([(np.roll(height, -1, a) - np.roll(height, 1, a)) for a in (2, 1, 0)], axis=-1)
    gradient /= 2.0 * np.quantile(np.abs(gradient), 0.995)
    values = np.concatenate([0.5 + gradient, height[..., None]], axis=-1)
    return np.round(255.0 * np.clip(values, 0.0, 1.0)).astype(np.uint8)


def papillae_texture(context: moderngl.Context) -> moderngl.Texture3D:
    """The volume on the graphics device, repeating, with mipmaps so that it fades with distance."""
    texture = context.texture3d((_SIZE, _SIZE, _SIZE), 4, papillae_volume().tobytes())
    texture.repeat_x = texture.repeat_y = texture.repeat_z = True
    texture.build_mipmaps()
    texture.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
    return texture
