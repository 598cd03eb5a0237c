"""A motor: what a motor file says."""

from __future__ import annotations

import os
from typing import Any, Iterator, Mapping, Union

from . import _motorlab

_KEYS = tuple(_motorlab.Motor.keys())


class Motor:
    """A motor with the lab handout's numbers, or others, as attributes in SI.

    Parameters
    ----------
    tolerance
        Relative one-sigma tolerance by key: 0.05 is 5 %.
    effects
        Effects that are part of the model, each with its parameters; what is left out has its default.
    **parameters
        Keys of a motor file: resistance_ohm, back_emf_v_s_per_rad, torque_constant_nm_per_a,
        viscous_friction_nm_s_per_rad, inductance_h, inertia_kg_m2, coulomb_friction_nm, counts_per_rev, supply_v.

    Examples
    --------
    >>> motor = Motor(resistance_ohm=8.0, effects={"backlash": {"gap_rad": 0.02}})
    >>> motor.inertia_kg_m2 = 0.003
    >>> motor["resistance_ohm"], motor.inertia_kg_m2
    (8.0, 0.003)
    >>> sorted(motor.effects["backlash"])
    ['encoder_side', 'gap_rad', 'load_fraction', 'load_friction_weight']
    >>> Motor(resistence_ohm=8.0)
    Traceback (most recent call last):
    ...
    motorlab.MotorlabError: unknown key 'resistence_ohm'
    hint: did you mean 'resistance_ohm'? `motorlab motor --template` prints all keys
    """

    _motor: _motorlab.Motor

    def __init__(
        self,
        *,
        tolerance: Mapping[str, float] | None = None,
        effects: Mapping[str, Mapping[str, float]] | None = None,
        **parameters: float,
    ) -> None:
        object.__setattr__(self, "_motor", _motorlab.Motor())
        for key, value in parameters.items():
            self._motor.set(key, value)
        for key, sigma in (tolerance or {}).items():
            self._motor.set_tolerance(key, sigma)
        for effect, values in (effects or {}).items():
            self._motor.set_effect(effect, dict(values))

    @classmethod
    def _of(cls, motor: _motorlab.Motor) -> Motor:
        made = cls()
        object.__setattr__(made, "_motor", motor)
        return made

    @classmethod
    def load(cls, path: Union[str, os.PathLike[str]]) -> Motor:
        """Read a motor file; keys that it lacks are the lab handout's.

        >>> import tempfile, pathlib
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "motor.toml"
        >>> Motor(supply_v=12.0).save(path)
        >>> Motor.load(path).supply_v
        12.0
        """
        motor, _ = _motorlab.Motor.load(path)
        return cls._of(motor)

    @classmethod
    def from_toml(cls, text: str) -> Motor:
        """Read the text of a motor file.

        >>> Motor.from_toml("supply_v = 6").supply_v
        6.0
        """
        return cls._of(_motorlab.Motor.from_toml(text))

    def save(self, path: Union[str, os.PathLike[str]], *, overwrite: bool = False) -> None:
        """Write a motor file. One that exists is replaced only with ``overwrite``."""
        self._motor.save(path, overwrite)

    def to_toml(self) -> str:
        """The text of a motor file that reads back as this motor."""
        return self._motor.to_toml()

    def replace(self, **parameters: float) -> Motor:
        """The same motor with other parameters.

        >>> Motor().replace(supply_v=9.0).supply_v
        9.0
        """
        other = Motor.from_toml(self.to_toml())
        for key, value in parameters.items():
            other._motor.set(key, value)
        return other

    @property
    def parameters(self) -> dict[str, float]:
        """Every parameter by its key, in SI.

        >>> Motor().parameters["counts_per_rev"]
        720.0
        """
        return {key: self._motor.get(key) for key in _KEYS}

    @property
    def tolerance(self) -> dict[str, float]:
        """Relative one-sigma tolerance by key."""
        return self._motor.tolerance()

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        """Effects that are part of the model, with their parameters."""
        return self._motor.effects()

    def set_effect(self, effect: str, **parameters: float) -> None:
        """Put an effect into the model; what is left out has its default for this motor.

        >>> motor = Motor()
        >>> motor.set_effect("dead_zone", threshold_v=0.5)
        >>> motor.effects
        {'dead_zone': {'threshold_v': 0.5}}
        """
        self._motor.set_effect(effect, parameters)

    def remove_effect(self, effect: str) -> bool:
        """Take an effect out of the model; whether it was there."""
        return self._motor.remove_effect(effect)

    def __getattr__(self, key: str) -> float:
        if key in _KEYS:
            return self._motor.get(key)
        raise AttributeError(f"a motor has no {key}; its parameters: {', '.join(_KEYS)}")

    def __setattr__(self, key: str, value: Any) -> None:
        self._motor.set(key, value)

    def __getitem__(self, key: str) -> float:
        return self._motor.get(key)

    def __setitem__(self, key: str, value: float) -> None:
        self._motor.set(key, value)

    def keys(self) -> tuple[str, ...]:
        """The keys of the parameters, so that ``dict(motor)`` has them all."""
        return _KEYS

    def __iter__(self) -> Iterator[str]:
        return iter(_KEYS)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *_KEYS]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Motor) and self._motor == other._motor

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        own = Motor().parameters
        said = [f"{key}={value!r}" for key, value in self.parameters.items() if value != own[key]]
        for name, values in (("tolerance", self.tolerance), ("effects", self.effects)):
            if values:
                said.append(f"{name}={values!r}")
        return f"Motor({', '.join(said)})"

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [[key, f"{value:.6g}"] for key, value in self.parameters.items()]
        rows += [
            [f"{effect}.{key}", f"{value:.6g}"]
            for effect, values in self.effects.items()
            for key, value in values.items()
        ]
        return table(["parameter", "value"], rows)
