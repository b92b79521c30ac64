r"""What is linear in a contrast image: levels, of which the first is the light, and a smooth field over what it covers.

They are solved for wherever the search for all other numbers stands (`estimate.sector_image`), by weighted least squares with
a prior p, N x = (A^T W^2 A + p^2) x = A^T W^2 s. How the misfit r = W (A x - s) changes beside a place then takes no second
solution: to first order,

.. math::
    N\, \Delta x = -A^T W \Delta_x r - (\Delta A)^T W r, \qquad \Delta r = \Delta_x r + W A\, \Delta x,

where :math:`\Delta_x r` is the change while x is held. The term in W r is of the size of the misfit and changes no gradient
(Kaufman leaves it out, as does `inference.variable_projection`), but along a valley all changes are small, and slopes without
it foretell them wrongly.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from irtiming.physics.smooth_field import SmoothField
from irtiming.records.arrays import Array, ComplexArray, Mask

_FREE = 2  # terms, light and plate, of which nothing is known beforehand


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Linear:
    """Terms of an image, turned back by each pixel's phase, and the weights of its pixels.

    ``levels`` (n_level, row, column) and ``cover`` (row, column), how much of the field shows, complex;
    ``basis`` of the field; ``u_dn`` the uncertainty of each ``good`` pixel along its phase, real, and across, imaginary.
    """

    levels: ComplexArray
    cover: ComplexArray
    basis: SmoothField
    good: Mask
    u_dn: ComplexArray

    @cached_property
    def along(self) -> Array:
        """Weight of each pixel along its phase, shape (row, column)."""
        return np.asarray(self.good / np.square(self.u_dn.real))

    @cached_property
    def across(self) -> Array:
        """Across it."""
        return np.asarray(self.good / np.square(self.u_dn.imag))

    @cached_property
    def mean(self) -> Array:
        """Of each basis function over the light, shape (n_basis,): an even field is the contrast, which lies where it does."""
        light = np.asarray(self.levels[0].real, dtype=float)
        return np.asarray(self.basis.sums(light) / light.sum())

    def field(self, found: Array) -> Array:
        """Smooth field of all terms' amounts, shape (n_level + n_basis,), counted from its mean over the light; (row, column)."""
        heights = found[len(self.levels) :]
        return np.asarray(self.basis.at(heights) - heights @ self.mean)

    def image(self, found: Array) -> ComplexArray:
        """What these amounts of all terms show, shape (row, column)."""
        levels = np.einsum("k,kij->ij", found[: len(self.levels)], self.levels)
        return np.asarray(levels + self.field(found) * self.cover)

    def sums(self, image: ComplexArray) -> Array:
        """Weighted sums of each term times an image, shape (n_level + n_basis,)."""
        of_levels = np.einsum("kij,ij->k", self._weighted.conj(), image).real
        return np.concatenate([of_levels, self._field_sums(image)])

    def normal(self) -> Array:
        """Normal matrix of all terms, shape (n_level + n_basis, n_level + n_basis)."""
        mixed = np.array([self._field_sums(level) for level in self.levels])
        of_levels = np.einsum("kij,lij->kl", self._weighted.conj(), self.levels).real
        weight = self.along * self.cover.real**2 + self.across * self.cover.imag**2
        plain, total, mean = self.basis.sums(weight), float(weight.sum()), self.mean
        of_field = self.basis.products(weight) - np.outer(mean, plain) - np.outer(plain - total * mean, mean)
        return np.block([[of_levels, mixed], [mixed.T, of_field]])

    def in_units(self, image: ComplexArray) -> Array:
        """An image's good pixels over their uncertainties, along their phase and then across, shape (2 n_good,)."""
        return np.concatenate([(image.real / self.u_dn.real)[self.good], (image.imag / self.u_dn.imag)[self.good]])

    @cached_property
    def _weighted(self) -> ComplexArray:
        return self.levels.real * self.along + 1j * (self.levels.imag * self.across)

    def _field_sums(self, image: ComplexArray) -> Array:
        weighted = self.along * self.cover.real * image.real + self.across * self.cover.imag * image.imag
        return np.asarray(self.basis.sums(weighted) - self.mean * weighted.sum())


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Solved:
    """Amounts of all terms, shape (n,), found for an image; ``off`` (row, column) is the model minus it.

    ``prior`` (n,) is one over the standard deviation that each amount has beforehand; 0, of light and plate, where there is none.
    """

    linear: Linear
    normal: Array
    prior: Array
    found: Array
    off: ComplexArray

    @property
    def misfit(self) -> Array:
        """Deviations of the good pixels along and across their phase, and of amounts from the prior, over their uncertainties."""
        return np.concatenate([self.linear.in_units(self.off), (self.prior * self.found)[_FREE:]])

    def change(self, beside: Linear, image: ComplexArray) -> Array:
        """By how much the misfit differs, to first order, with other terms and another image, shape of the misfit."""
        change = beside.image(self.found) - image - self.off
        taken = self._inverse @ (self.linear.sums(change) + beside.sums(self.off) + self.prior**2 * self.found)
        return np.concatenate([self.linear.in_units(change - self.linear.image(taken)), (-self.prior * taken)[_FREE:]])

    def log_evidence(self, heights: Array) -> Array:
        """How likely the image is where heights of the field have that standard deviation, as a share of the light, shape (n,).

        All heights are integrated out, levels as well, of a Gaussian: with what is left of the normal matrix beside the levels,
        of eigenvalues d, and of the sums along its axes z, its logarithm is, but for what no height changes,
        1/2 sum z^2 / (d + p^2) - log(1 + d / p^2).
        """
        n, sums = len(self.linear.levels), self.normal @ self.found
        mixed, own = self.normal[:n, n:], self.normal[n:, n:] - np.diag(self.prior[n:] ** 2)
        of_levels = np.linalg.solve(self.normal[:n, :n], np.column_stack([mixed, sums[:n]]))
        told, axes = np.linalg.eigh(own - mixed.T @ of_levels[:, :-1])
        told, along = np.maximum(told, 0.0), axes.T @ (sums[n:] - mixed.T @ of_levels[:, -1])
        prior = (heights[:, None] * self.found[0]) ** -2.0
        return np.asarray(np.sum(along**2 / (told + prior) - np.log1p(told / prior), axis=1) / 2)

    @cached_property
    def _inverse(self) -> Array:
        return np.asarray(np.linalg.inv(self.normal), dtype=float)


def solved(linear: Linear, image: ComplexArray, *, field_prior: float) -> Solved:
    """Amounts that fit an image of shape (row, column) best; those of the field are ``field_prior`` of the light, roughly.

    Those of further levels than light and plate are in standard uncertainties of the light's.
    """
    normal, sums, n = linear.normal(), linear.sums(image), len(linear.levels)
    contrast = abs(sums[0] / normal[0, 0])
    prior = np.concatenate(
        [np.zeros(_FREE), np.full(n - _FREE, 1 / contrast), np.full(sums.size - n, 1 / (field_prior * contrast))]
    )
    normal += np.diag(prior**2)
    found = np.asarray(np.linalg.solve(normal, sums), dtype=float)
    return Solved(linear=linear, normal=normal, prior=prior, found=found, off=linear.image(found) - image)
