"""A network written down: what a charging mode holds of it, and what the search for one hands on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Self

from pydantic import Field, model_validator

from pipeline.record import Record

if TYPE_CHECKING:
    from pipeline.grnn.network import Network

KERNELS = ("gaussian", "wendland", "extendable")


class ChargerNetwork(Record):
    """A generalised regression neural network from temperature and its gradient to a charging rate.

    Its fields are those of `pipeline.grnn.network.make_network`, which says what they are.
    """

    centres: list[tuple[float, float]] = Field(
        min_length=1, max_length=4096, description="temperature and gradient of each centre [degC, unit of dT/dt]"
    )
    outputs_c_rate: list[float] = Field(min_length=1, description="charging rate at each centre [C-rate]")
    widths: tuple[float, float] = Field(description="width of the kernel along each scaled input [1]")
    scales: tuple[float, float] = Field((1.0, 1.0), description="what each input is divided by [degC, unit of dT/dt]")
    kernel: Literal["gaussian", "wendland", "extendable"] = Field("gaussian", description="radial basis function")
    extension: float = Field(2.0, gt=1, description="radius of an extended support over the nearest distance [1]")
    low: tuple[float, float] = Field(description="lower ends of the data, at which inputs are held [degC, unit]")
    high: tuple[float, float] = Field(description="upper ends of the data [degC, unit of dT/dt]")
    gradient_seconds: float = Field(gt=0, description="seconds in the unit of dT/dt: 60 for K/min [s]")

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if len(self.centres) != len(self.outputs_c_rate):
            raise ValueError(
                f"centres are {len(self.centres)} but outputs_c_rate are {len(self.outputs_c_rate)}; give one each"
            )
        for name in ("widths", "scales"):
            if min(getattr(self, name)) <= 0.0:
                raise ValueError(f"{name} is {list(getattr(self, name))}; each must be greater than 0")
        if any(low >= high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError(f"low {list(self.low)} must lie below high {list(self.high)}")
        return self

    def compiled(self) -> Network:
        """Return the network as the kernels take it."""
        from pipeline.grnn.network import make_network

        return make_network(
            self.centres,
            self.outputs_c_rate,
            widths=self.widths,
            scales=self.scales,
            kernel=self.kernel,
            extension=self.extension,
            low=self.low,
            high=self.high,
            gradient_seconds=self.gradient_seconds,
        )


def charger_network(network: Network) -> ChargerNetwork:
    """Return a network of two inputs as a record."""
    return ChargerNetwork.model_validate(
        {
            "centres": network.centres.tolist(),
            "outputs_c_rate": network.outputs.tolist(),
            "widths": network.widths.tolist(),
            "scales": network.scales.tolist(),
            "kernel": KERNELS[network.kernel],
            "extension": network.extension,
            "low": network.low.tolist(),
            "high": network.high.tolist(),
            "gradient_seconds": network.gradient_seconds,
        }
    )
