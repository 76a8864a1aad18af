"""Numbers and operands as the sentences of verdicts say them; units are those that the tables declare."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from pipeline.published.artefacts import Reader
from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value, values
from pipeline.published.reference import PRINTED, kind

_ACRONYMS = {"soc": "SOC", "ise": "ISE", "mse": "MSE", "anfis": "ANFIS"}


def plain(value: float, unit: str = "1") -> str:
    """Return a number to five digits with its unit; an infinite time reads `never`."""
    if math.isinf(value):
        return "never" if unit == "s" and value > 0 else "without bound"
    text = f"{value:.5g}" if abs(value) < 1e5 else f"{value:.0f}"
    return text if unit in ("1", "") else f"{text} {unit}"


class Wording:
    """Operands in words.

    Arguments
    ---------
    reader : the artefacts, which know the units of their values.
    unit : unit of what the statement compares, for operands that no table declares.
    """

    def __init__(self, reader: Reader, unit: str) -> None:
        self._reader = reader
        self._unit = unit

    def unit(self, operands: Iterable[Operand]) -> str:
        """Return the unit of operands that are compared: that of the first value whose table declares one, else
        the statement's.
        """
        found = (self._reader.unit(one) for one in operands if isinstance(one, Value))
        return next((unit for unit in found if unit is not None), self._unit)

    def shape(self, operand: Operand) -> str:
        """Return an operand as words, without saying of which artefact."""
        match operand:
            case Value():
                return self._words(operand, operand.quantity)
            case Difference(difference=(left, right)):
                return f"{self._part(left)} - {self._part(right)}"
            case Ratio(ratio=(left, right)):
                if len(_owners(operand)) > 1:
                    return f"{self.label(left)} / {self.label(right)}"
                return f"{self._part(left)} / {self._part(right)}"
            case Product(product=factors):
                return " x ".join(self._part(factor) for factor in factors)
            case Total(total=column):
                return f"sum of {self.shape(column)}"
            case AtTime(at_time=moment):
                return f"{self.label(moment.value)} at {self.label(moment.time)}"
            case _:
                return plain(float(operand))

    def _part(self, operand: Operand) -> str:
        text = self.shape(operand)
        return f"({text})" if isinstance(operand, (Difference, Ratio)) else text

    def label(self, operand: Operand) -> str:
        """Return an operand as words with its artefact, and with its row where it has one."""
        owners = _owners(operand)
        if len(owners) != 1 or isinstance(operand, AtTime):
            return self.shape(operand)
        owner = owners.pop()
        first, *others = values(operand)
        row = "" if any(one.where != first.where for one in others) else self._row(first, first.where)
        printed, text = kind(owner) == PRINTED, self.shape(operand)
        told = f"printed {text}" if printed else f"{text} of {' '.join(artefact_name(owner))}"
        return told + (f", {row}" if row else "")

    def compared(self, operands: Sequence[Operand], found: Sequence[float]) -> str:
        """Return operands with their numbers, what they are said once where they differ only in artefact or row."""
        unit = self.unit(operands)
        numbers = [plain(value, unit) for value in found]
        names, shared = self._alike(operands)
        if names:
            told = (f"{name} {number}" for name, number in zip(names, numbers, strict=True))
            return f"{self.shape(operands[0])}{shared}: {', '.join(told)}"
        alone = all(kind(owner) == PRINTED for one in operands for owner in _owners(one))
        return "; ".join(self._stated(one, number, alone) for one, number in zip(operands, numbers, strict=True))

    def names(self, operands: Sequence[Operand]) -> list[str]:
        """Return what operands are called once `compared` has told them: what tells them apart, or their order."""
        names, _ = self._alike(operands)
        order = ["first", "second"] if len(operands) == 2 else ["first", *["another"] * (len(operands) - 1)]
        return names if len(set(names)) == len(operands) else order

    def _stated(self, operand: Operand, number: str, alone: bool) -> str:
        """Return an operand with its number, or the number alone where the operand is one.

        Arguments
        ---------
        alone : whether nothing but printed values is compared, so that each is called by its name.
        """
        if isinstance(operand, float):
            return number
        if not values(operand):
            return f"{self.shape(operand)} = {number}"
        printed = isinstance(operand, Value) and kind(operand.artefact) == PRINTED and not alone
        return f"printed: {number}" if printed else f"{self.label(operand)}: {number}"

    def _alike(self, operands: Sequence[Operand]) -> tuple[list[str], str]:
        """Return what tells operands apart that differ only in artefact or row, and what they share; else nothing."""
        owners = [_owners(one) for one in operands]
        if len(operands) < 2 or len({self.shape(one) for one in operands}) > 1 or any(len(one) != 1 for one in owners):
            return [], ""
        rows = self._rows(operands)
        if rows:
            return rows, ""
        names = [artefact_name(owner.pop()) for owner in owners]
        shared = {group for _, *group_ in names for group in group_ or [""]}
        if len(shared) == 1 and "" not in shared:
            return [name for name, *_ in names], f" {shared.pop()}"
        return [" ".join(name) for name in names], ""

    def _rows(self, operands: Sequence[Operand]) -> list[str]:
        """Return the rows of values of one table by what tells them apart; nothing where there are more tables."""
        found = [one for one in operands if isinstance(one, Value) and one.where]
        if len(found) < len(operands) or len({one.artefact for one in found}) > 1:
            return []
        rows = [one.where for one in found]
        told = [
            self._row(one, [name for name in one.where if len({str(other.get(name)) for other in rows}) > 1])
            for one in found
        ]
        return told if all(told) else []

    def _row(self, value: Value, columns: Iterable[str]) -> str:
        """Return what a value asks of some columns of its row."""
        told = []
        for name in columns:
            wanted = value.where[name]
            unit = self._reader.unit(value.model_copy(update={"quantity": name, "where": {}})) or "1"
            text = plain(wanted, unit) if isinstance(wanted, float) else wanted
            told.append(f"{self._words(value, name)} {text}")
        return ", ".join(told)

    def _words(self, value: Value, name: str) -> str:
        """Return a quantity or column as words, without the ending that repeats its unit; a paper's own as it is."""
        if kind(value.artefact) == PRINTED:
            return name
        unit = self._reader.unit(value.model_copy(update={"quantity": name, "where": {}})) or "1"
        for per in ("_", "_per_"):
            ending = "_" + unit.lower().removeprefix("deg").replace("/", per).replace(" ", "_")
            if unit != "1" and name.endswith(ending):
                name = name.removesuffix(ending)
                break
        name = name.removesuffix(f" / {unit}")
        return " ".join(_ACRONYMS.get(word, word) for word in name.split("_"))


def artefact_name(artefact: str) -> tuple[str, ...]:
    """Return the last part of a name of several parts and the one before in brackets, else the name as it is."""
    parts = artefact.split("/")
    return (parts[-1], f"({parts[-2].replace('_', ' ')})") if len(parts) > 2 else (artefact,)


def _owners(operand: Operand) -> set[str]:
    return {value.artefact for value in values(operand)}
