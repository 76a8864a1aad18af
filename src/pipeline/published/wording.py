"""Numbers and operands as the sentences of verdicts say them; units are those that the tables declare."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from pipeline.kernel.experiment import kind_of
from pipeline.published.artefacts import Reader, Unanswerable
from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value, values
from pipeline.published.records import Told
from pipeline.published.reference import PRINTED

_ACRONYMS = {"soc": "SOC", "ise": "ISE", "mse": "MSE", "anfis": "ANFIS", "grnn": "GRNN"}
_SIGNS = (("degC", "°C"), ("ohm", "Ω"), ("rate2", "rate²"), ("mW2", "mW²"), ("m2", "m²"))
_SMALL = ("J", "W", "A", "V", "s")
"""Units of which small numbers are told in millionths."""
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MOST = 5
"""Digits of a number that are told at most, but for those in front of its point."""
SAME = 1e-9
"""Share of what is allowed below which a deviation is what rounding left over."""


def sign(unit: str) -> str:
    """Return a unit as it is printed; nothing for a pure number."""
    for name, printed in _SIGNS:
        unit = unit.replace(name, printed)
    return "" if unit == "1" else unit


def of_differences(unit: str) -> str:
    """Return the unit of differences: degrees of difference are kelvins."""
    return "K" if unit == "degC" else unit


def plain(value: float, unit: str = "1", apart: float = 0.0) -> str:
    """Return a number for people: three digits, or as many as a difference takes; an infinite time reads `never`.

    Arguments
    ---------
    value : the number.
    unit : its unit, which stands behind it.
    apart : a difference that must not be lost: two of its digits are told.
    """
    if math.isinf(value):
        return "never" if unit == "s" and value > 0 else "without bound"
    if 0.0 < abs(value) < 1e-3 and unit in _SMALL:
        value, apart, unit = 1e6 * value, 1e6 * apart, f"µ{unit}"
    return f"{_digits(value, apart)} {sign(unit)}".rstrip()


def exact(value: float, unit: str = "1") -> str:
    """Return a number that somebody wrote as it was written, with its unit."""
    whole = value == round(value) and abs(value) < 1e9
    return f"{_signed(f'{value:.0f}' if whole else f'{value:.5g}')} {sign(unit)}".rstrip()


def _digits(value: float, apart: float) -> str:
    if value == 0.0 or (abs(value) < 1e9 and value == round(value)):
        return _signed(f"{value:.0f}")
    size = _size(value)
    if not -4 <= size < 9:
        return _signed(f"{value:.2e}")
    places = 2 - size
    if 0.0 < abs(apart) < math.inf:
        places = min(max(places, 1 - _size(apart)), _MOST - 1 - size)
    text = f"{value:.{max(places, 0)}f}"
    round_ = math.isclose(float(text), value, rel_tol=SAME) and "." in text
    return _signed(text.rstrip("0") if round_ else text)


def _size(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _signed(text: str) -> str:
    """Return a number with a true minus sign and a power of ten as it is written."""
    mantissa, power, exponent = text.partition("e")
    if power:
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        lead = mantissa.removesuffix("1") if mantissa in ("1", "-1") else f"{mantissa} × "
        return f"{lead}10{str(int(exponent)).translate(_RAISED)}".replace("-", "−")
    return "0" if text.strip("-0.") == "" else text.replace("-", "−")


def opened(text: str) -> str:
    """Return a text as a sentence begins; a symbol, as dT/dt, keeps its letter."""
    return text[:1].upper() + text[1:] if text[1:2].islower() or text[1:2] == " " else text


class Wording:
    """Operands in words.

    Arguments
    ---------
    reader : the artefacts, which know the units of their values.
    unit : unit of what the statement compares, for operands that no table declares.
    called : quantity, column, mode or comparison -> what it is called; an empty word leaves it out.
    known : columns of rows that were told before.
    """

    def __init__(
        self, reader: Reader, unit: str, called: Mapping[str, str] | None = None, known: Iterable[str] = ()
    ) -> None:
        self._reader = reader
        self._unit = unit
        self._called = called or {}
        self._known = set(known)

    def unit(self, operands: Iterable[Operand]) -> str:
        """Return the unit of operands that are compared: that of the first value whose table declares one, else
        the statement's.
        """
        found = (self._reader.unit(one) for one in operands if isinstance(one, Value))
        return next((unit for unit in found if unit is not None), self._unit)

    def reason(self, lack: Unanswerable) -> str:
        """Return why there is no answer, the operand that has no number in words."""
        return lack.why if lack.operand is None else f"{self.label(lack.operand)} {lack.why}"

    def shape(self, operand: Operand) -> str:
        """Return an operand as words, without saying of which artefact."""
        match operand:
            case Value():
                return self._words(operand, operand.quantity)
            case Difference(difference=(left, right)):
                return f"{self._part(left)} − {self._part(right)}"
            case Ratio(ratio=(left, right)):
                if len(_owners(operand)) > 1:
                    return f"{self.label(left)} / {self.label(right)}"
                return f"{self._part(left)} / {self._part(right)}"
            case Product(product=factors):
                return " × ".join(self._part(factor) for factor in factors)
            case Total(total=column):
                return f"sum of {self.shape(column)}"
            case AtTime(at_time=moment):
                if len(_owners(operand)) == 1:
                    return f"{self.shape(moment.value)} at {self.shape(moment.time)}"
                return f"{self.label(moment.value)} at {self.label(moment.time)}"
            case _:
                return exact(float(operand))

    def _part(self, operand: Operand) -> str:
        text = self.shape(operand)
        return f"({text})" if isinstance(operand, (Difference, Ratio)) else text

    def label(self, operand: Operand) -> str:
        """Return an operand as words with the charge or the paper it is of, and with its row where it has one."""
        owners = _owners(operand)
        if len(owners) != 1:
            return self.shape(operand)
        owner = owners.pop()
        first, *others = values(operand)
        row = "" if any(one.where != first.where for one in others) else self.row(first, first.where)
        (*named, group), text = self._artefact(owner), self.shape(operand)
        if kind_of(owner) == PRINTED and not text.startswith("printed"):
            text = f"printed {text}"
        text = " of ".join([text, *named])
        told = ", ".join(part for part in (group, row) if part)
        return f"{text} ({told})" if told else text

    def compared(
        self, operands: Sequence[Operand], found: Sequence[float], told: Told | None = None, apart: float = 0.0
    ) -> str:
        """Return operands with their numbers, what they are said once where they differ only in artefact or row.

        Arguments
        ---------
        operands, found : what is compared, and its numbers.
        told : the predicate, which may say how they are called.
        apart : a difference between numbers that must not be lost.
        """
        unit = self.unit(operands)
        numbers = [plain(value, unit, apart) for value in found]
        names, subject = self._alike(operands, told)
        if names and subject:
            return f"{subject}: {', '.join(_beside(names, numbers))}"
        if names:
            return "; ".join(f"{name}: {number}" for name, number in zip(names, numbers, strict=True))
        return "; ".join(self._stated(one, number) for one, number in zip(operands, numbers, strict=True))

    def names(self, operands: Sequence[Operand], told: Told | None = None) -> list[str]:
        """Return what operands are called once `compared` has told them apart; nothing where only their order does."""
        names, subject = self._alike(operands, told)
        return names if subject and len(set(names)) == len(operands) else []

    def row(self, value: Value, columns: Iterable[str]) -> str:
        """Return what a value asks of some columns of its row, without what was told before."""
        told = []
        for name in columns:
            wanted = value.where[name]
            if name in self._known:
                continue
            unit = self._reader.unit(value.model_copy(update={"quantity": name, "where": {}})) or "1"
            if isinstance(wanted, float):
                told.append(f"{self._words(value, name)} {exact(wanted, unit)}")
            else:
                told.append(self._called.get(wanted, wanted.replace("_", " ")))
        return ", ".join(told)

    def _stated(self, operand: Operand, number: str) -> str:
        """Return an operand with its number, or the number alone where the operand is one."""
        if isinstance(operand, float):
            return number
        return f"{self.label(operand)}: {number}" if values(operand) else f"{self.shape(operand)} = {number}"

    def _alike(self, operands: Sequence[Operand], told: Told | None = None) -> tuple[list[str], str]:
        """Return what tells operands apart, and what they share: as the predicate calls them, else where they differ
        only in artefact or row; nothing where neither is so.
        """
        if told is not None and told.called:
            return list(told.called)[: len(operands)], told.of
        owners = [_owners(one) for one in operands]
        if len(operands) < 2 or len({self.shape(one) for one in operands}) > 1 or any(len(one) != 1 for one in owners):
            return [], ""
        rows, shared = self._rows(operands)
        if rows:
            shape = self.shape(operands[0])
            return rows, f"{shape} ({shared})" if shared else shape
        artefacts = [self._artefact(owner.pop()) for owner in owners]
        if any(len(one) < 2 for one in artefacts):
            return [], ""
        shape, groups = self.shape(operands[0]), {group for *_, group in artefacts}
        if len(groups) > 1:
            return [f"{name} ({group})" for name, group in artefacts], shape
        group = groups.pop()
        return [name for name, _ in artefacts], f"{shape} ({group})" if group else shape

    def _rows(self, operands: Sequence[Operand]) -> tuple[list[str], str]:
        """Return the rows of values of one table by what tells them apart, and what they share; nothing where there
        are more tables.
        """
        found = [one for one in operands if isinstance(one, Value) and one.where]
        if len(found) < len(operands) or len({one.artefact for one in found}) > 1:
            return [], ""
        rows = [one.where for one in found]
        apart = {name for one in rows for name in one if len({str(other.get(name)) for other in rows}) > 1}
        told = [self.row(one, [name for name in one.where if name in apart]) for one in found]
        shared = self.row(found[0], [name for name in found[0].where if name not in apart])
        return (told, shared) if all(told) else ([], "")

    def _artefact(self, artefact: str) -> tuple[str, ...]:
        """Return whose numbers an artefact holds: the mode and the comparison; an empty word alone for any other."""
        parts = artefact.split("/")
        if len(parts) < 3:
            return ("",)
        group, name = (self._called.get(part, part) for part in parts[-2:])
        return name, group.replace("_", " ")

    def _words(self, value: Value, name: str) -> str:
        """Return a quantity or column as words, without the ending that repeats its unit; a paper's own as it is."""
        if name in self._called:
            return self._called[name]
        if kind_of(value.artefact) == PRINTED:
            return name
        unit = self._reader.unit(value.model_copy(update={"quantity": name, "where": {}})) or "1"
        for per in ("_", "_per_"):
            ending = "_" + unit.lower().removeprefix("deg").replace("/", per).replace(" ", "_")
            if unit != "1" and name.endswith(ending):
                name = name.removesuffix(ending)
                break
        name = name.removesuffix(f" / {unit}")
        return " ".join(_ACRONYMS.get(word, word) for word in name.split("_"))


def _beside(names: Sequence[str], numbers: Sequence[str]) -> list[str]:
    """Return names with their numbers, in brackets behind them where a name ends in a number itself."""
    if any(sign.isdigit() for name in names for sign in name[-4:]):
        return [f"{number} ({name})" for name, number in zip(names, numbers, strict=True)]
    return [f"{name} {number}" for name, number in zip(names, numbers, strict=True)]


def _owners(operand: Operand) -> set[str]:
    return {value.artefact for value in values(operand)}
