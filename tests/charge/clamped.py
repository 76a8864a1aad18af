"""Any battery's equations written anew over its record, by scipy's integrators: a charger that never draws."""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from pipeline.cell.records import Tabulated, value_of

R_F, KELVIN = 8.314462618 / 96485.33212, 273.15


def curve(record):
    if isinstance(record, Tabulated):
        spline = PchipInterpolator(record.soc, record.scale * np.array(record.value))
        return lambda soc: float(spline(soc))
    return lambda soc: value_of(record, soc)


class Reference:
    """State: 1 - SOC, temperature, hysteresis, pairs, acceptance pair, recombination, charge in and out, energy."""

    def __init__(self, battery, soc, ambient_c=25.0):
        self.b, self.k = battery, battery.capacity_in_use_ah / battery.capacity_ah
        self.open_v, self.entropy = curve(battery.open_circuit_voltage_v), curve(battery.entropic_coefficient_v_k)
        self.ohm = curve(battery.series_resistance_ohm)
        self.pairs = [(curve(p.resistance_ohm), p.time_constant_s) for p in battery.pairs.values()]
        self.exchange = curve(battery.charge_transfer.exchange_current_a) if battery.charge_transfer else None
        self.n = len(self.pairs) + (battery.acceptance is not None)
        self.ambient_k = ambient_c + KELVIN
        hysteresis = battery.hysteresis
        start_v = hysteresis.initial_share * hysteresis.amplitude_v if hysteresis else 0.0
        self.y = np.array([1 - soc, self.ambient_k, start_v, *np.zeros(self.n), 0.0, 0.0, 0.0, 0.0])

    def parts(self, y):
        soc, t = 1 - y[0], y[1]
        slow = self.open_v(soc) + self.entropy(soc) * (t - 298.15) + y[2]
        return slow + float(np.sum(y[3 : 3 + self.n])), self.ohm(soc) / self.k, soc, t

    def side(self, node, t):
        s = self.b.side_reaction
        if s is None:
            return 0.0
        scale = s.voltage_scale_v or s.thermal_voltages * R_F * t
        ref = s.reference_temperature_c + KELVIN
        warm = s.temperature_coefficient_per_k * (t - ref) - s.activation_energy_j_mol / 8.314462618 * (1 / t - 1 / ref)
        return self.k * s.current_a * math.exp(min((node - s.reference_voltage_v) / scale + warm, 300.0))

    def eta(self, main, soc, t):
        return 2 * R_F * t * math.asinh(main / (2 * self.k * self.exchange(soc))) if self.exchange else 0.0

    def at(self, y, total=None, volts=None):
        """Total and main current, node and terminal voltage of a cell, for a current or for a voltage."""
        base, ohm, soc, t = self.parts(y)
        if self.exchange is None:
            side = self.side(base, t)
            total = (volts - base) / ohm if total is None else total
            return total, total - side, base, base + ohm * total

        def of(main):
            node = base + self.eta(main, soc, t)
            both = main + self.side(node, t)
            return both, main, node, node + ohm * both

        def missed(main):
            return of(main)[0] - total if volts is None else of(main)[3] - volts

        wide = 100 * self.b.capacity_in_use_ah
        return of(brentq(missed, -wide, wide, xtol=1e-14, rtol=1e-14))

    def current(self, y, asked, limit_v, power_w=math.inf):
        """What flows: what is asked, less where the limit or the supply says so, nothing where the battery is above."""
        found = self.at(y, total=asked)
        if found[3] > limit_v:
            found = self.at(y, volts=limit_v)
            if found[0] < 0.0:
                found = self.at(y, total=0.0)
        if self.b.cells_in_series * found[3] * found[0] > power_w:
            each = power_w / self.b.cells_in_series
            found = self.at(y, total=brentq(lambda i: self.at(y, total=i)[3] * i - each, 0.0, found[0], xtol=1e-14))
        return found

    def slopes(self, y, asked, limit_v, charging, power_w=math.inf):
        total, main, node, volts = self.current(y, asked, limit_v, power_w) if charging else self.at(y, total=asked)
        b, soc, t = self.b, 1 - y[0], y[1]
        charge_as, side = 3600 * b.capacity_in_use_ah, total - main
        out = np.zeros_like(y)
        out[0] = -main / charge_as
        entropy, ohm = self.entropy(soc), self.ohm(soc) / self.k
        if b.hysteresis:
            rate = b.hysteresis.rate_per_ah / self.k / 3600
            out[2] = rate * main * ((b.hysteresis.amplitude_v if main > 0 else 0.0) - y[2]) * (1 if main > 0 else -1)
        heat = ohm * total**2 + self.eta(main, soc, t) * main + y[2] * main
        if b.thermoneutral_voltage_v is not None:
            heat += main * (self.parts(y)[0] - float(np.sum(y[3 : 3 + self.n])) - y[2] - b.thermoneutral_voltage_v)
        else:
            heat += main * t * entropy
        for n in range(self.n):
            v = y[3 + n]
            if n < len(self.pairs):
                of, tau = self.pairs[n]
                r, step = of(soc) / self.k, 1e-6
                slope = (of(min(soc + step, 1)) - of(max(soc - step, 0))) / self.k
                slope /= min(soc + step, 1) - max(soc - step, 0)
            else:
                tau, r = b.acceptance.time_constant_s, b.acceptance.resistance_ohm / self.k / y[0]
                slope = r / y[0]
            drive = r * main
            if n == len(self.pairs) and v <= 0.0 and main <= 0.0:
                drive, v = 0.0, 0.0
            out[3 + n] = (drive - v) / tau
            # C = tau / R, dC/dt = -tau R' / R^2 ds/dt
            heat += v * v / r + 0.5 * v * v * tau * slope / r**2 * main / charge_as
        rec, gas = y[3 + self.n], 0.0
        if b.side_reaction:
            gas = b.side_reaction.gas_voltage_v
            lag = b.side_reaction.recombination_time_constant_s
            heat += side * node - ((side - rec) * gas if lag else 0.0)
            out[3 + self.n] = (side - rec) / lag if lag else 0.0
        lost = (t - self.ambient_k) * 1 / b.thermal.resistance_k_w * self.k
        out[1] = (b.cells_in_series * heat - lost) / (b.thermal.heat_capacity_j_k * self.k)
        out[4 + self.n] = max(total, 0.0)
        out[5 + self.n] = max(-total, 0.0)
        out[6 + self.n] = b.cells_in_series * volts * total
        return out

    def run(self, seconds, asked, limit_v=math.inf, charging=True, power_w=math.inf, rtol=1e-9):
        """Go on for so long; stops of the integrator at each change between current, limit and nothing."""
        limit_v /= self.b.cells_in_series

        def over(_, y):
            return self.at(y, total=asked)[3] - limit_v

        def above(_, y):
            return self.at(y, total=0.0)[3] - limit_v

        def paired(_, y):
            return y[2 + self.n] - 1e-15

        events = [over, above] if charging and math.isfinite(limit_v) else []
        if self.b.acceptance is not None:
            events.append(paired)
        left = seconds
        for event in events:
            event.terminal = True
        while left > 1e-12:
            found = solve_ivp(
                lambda _, y: self.slopes(y, asked, limit_v, charging, power_w), (0, left), self.y, "LSODA",
                rtol=rtol, atol=1e-12, events=events, max_step=max(left / 20, 1e-3),
            )  # fmt: skip
            self.y = found.y[:, -1]
            if self.b.acceptance is not None and self.y[2 + self.n] < 1e-12:
                self.y[2 + self.n] = 0.0
            step = found.t[-1]
            if step < 1e-9 and left > 1e-9:
                # Past the crossing, so that the same one is not found again.
                self.y = self.y + 1e-9 * self.slopes(self.y, asked, limit_v, charging, power_w)
                step = 1e-9
            left -= step

    def result(self):
        n = self.n
        return {
            "end_soc": 1 - self.y[0],
            "end_temperature_c": self.y[1] - KELVIN,
            "charge_in_ah": self.y[4 + n] / 3600,
            "charge_out_ah": self.y[5 + n] / 3600,
            "energy_wh": self.y[6 + n] / 3600,
        }
