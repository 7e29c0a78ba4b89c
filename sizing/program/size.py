"""prototype"""
from __future__ import annotations
import math, time
import numpy as np
from sizing.design import DesignVariables, FlightConditions, variables_of
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel, solar_day
from sizing.performance import performance_of_designs
from sizing.limits import meets_requirements
from sizing.parameters import parameter_value
from sizing.program.transcription import *
from sizing.program.corrections import *
from sizing.program.solve import *
from sizing.program.variables import *
from sizing.program.start import most_promising
CUSHION_H = 5e-4
FIRST_MARGIN = 2e-4

class Sizer:
    def __init__(self, aircraft, mission, objective, solar, required_h, blocks=3, day=None, continuous=()):
        self.aircraft, self.mission, self.objective, self.solar = aircraft, mission, objective, solar
        self.required_h = required_h
        self.day = solar_day(aircraft, mission, solar) if day is None else day
        self.count = len(self.day.scenarios)
        self.continuous = set(continuous)
        self.blocks = min(blocks, self.count)
        self.program = build_program(aircraft, self.blocks)
        self.variables = chosen_variables(aircraft)
        self.names = [v.name for v in self.variables]
        self.conditions = FlightConditions.of(mission, aircraft)
        self.all_continuous = len(self.continuous) == self.count
        self.best_excess = objective is Objective.max_excess_time and not self.all_continuous
        self.cost = Objective.min_mass.cost if objective is Objective.max_excess_time and self.all_continuous else objective.cost
        self.held = {"payload_mass_kg": mission.payload.mass_kg, "payload_power_w": mission.payload.power_w}
        self.free = [v.name for v in self.variables if v.name != TOTAL_MASS and (v.role is Role.design or v.name == objective.variable) and v.minimum < v.maximum]
        self.iterations = 0; self.solves = 0
        self.lowest = self.day.specific_power_w_per_m2.min(axis=-1)

    # values: dict name -> value
    def design_variables(self, values, clip=True):
        out = {"aspect_ratio": self.aircraft.airframe.aspect_ratio}
        for v in self.variables:
            if v.name in DesignVariables._fields and not (v.role is Role.payload and v.name not in self.free):
                val = values[v.name]
                out[v.name] = min(max(val, v.minimum), v.maximum) if clip else val
        return DesignVariables(**out)

    def fly(self, variables): 
        return performance_of_designs(self.aircraft, self.mission, variables, self.solar, day=self.day)

    def batch(self, values):
        """Design and its neighbours in the program's variables."""
        self.scales = scales_of(self.variables, values)
        rows = [self.design_variables(values)]
        for name in self.free:
            i = self.names.index(name); v = self.variables[i]
            x = v.to_program(values[name], self.scales[i]) + STEP
            rows.append(self.design_variables(values | {name: float(v.from_program(x, self.scales[i]))}, clip=False))
        names = rows[0].chosen()
        return self.fly(DesignVariables(**{n: np.array([float(d.chosen()[n]) for d in rows]) for n in names}))

    def data_of(self, perf, scenarios):
        b = self.aircraft.battery
        into, out = b.mean_charge_efficiency, b.mean_discharge_efficiency
        nominal_load = np.asarray(perf.nominal_load_w)
        solar = np.broadcast_to(perf.solar_power_w, (nominal_load.shape[0], self.count, len(self.day.time_h)))
        load = np.broadcast_to(perf.load_w, solar.shape)
        nominal_load = np.broadcast_to(nominal_load, solar.shape[:-1])
        level = np.asarray(perf.design.load_in_turbulence_w(self.mission.turbulence.all_day))
        area = np.asarray(perf.design.variables.module_area_m2)
        self.total_kg = float(np.asarray(perf.design.total_mass_kg)[0])
        self.lowest = solar[0].min(axis=-1) / area[0]
        self.reference_w = float(np.median(nominal_load[0]))
        full = float(np.asarray(perf.design.battery_energy_wh)[0]) / (RESERVE_SCALE_H * self.reference_w)
        charge = perf.cycle.energy_wh
        places = [self.names.index(n) for n in self.free]
        data, starts = [], []
        battery_wh = float(np.asarray(perf.design.battery_energy_wh)[0])
        store = perf.store.flat(nominal_load.shape).select(np.array([0]))
        ex = np.asarray(perf.cycle.excess_time_h)[0]
        for s in scenarios:
            day = Day.of(self.day.time_h, solar[:, s], load[:, s])
            alive = ex[s] > 0 and np.isfinite(ex[s])
            if alive:
                c = np.asarray(charge[0, s]) / battery_wh
                first = int(np.searchsorted(self.day.time_h, day.time_h[0] - 1e-9))
                path = c[(first + np.arange(len(c))) % (len(c) - 1)]
            else: path = day.path(store, self.dawn.get(s, 0.3))
            nodes = self.nodes.get(s)
            if nodes is None: nodes = self.nodes[s] = nodes_of(day, path, into, battery_wh, nominal_load[0, s])
            m = day_means(day, nodes, path, battery_wh, into, out)
            light, factor, w = m.light_w / area[:, None], m.load_w / level[:, None], m.hours
            slopes = np.zeros((2, INTERVALS + 1, len(self.variables)))
            nom = nominal_load[:, s] / level
            low = solar[:, s].min(axis=-1) / area
            for k, q in enumerate((np.column_stack([light, low]), np.column_stack([factor, nom]))):
                okay = (q > 0).all(axis=0)
                g = np.log(np.where(okay, q, 1.0)); slopes[k][:, places] = np.clip(np.nan_to_num((g[1:] - g[0]) / STEP), -3, 3).T
            at = equal_power_step(day, nominal_load[0, s])
            reserve = (np.arange(len(nodes)) <= 1 + np.argmin(np.abs(nodes - at))).astype(float)
            lit = float(s in self.continuous)
            data.append(BlockData(w, light[0], factor[0], nom[0], *[q.ravel(order='F') for q in slopes], self.shift[s], self.slope[s], reserve, self.margin[s], lit, lit * low[0], 1.0))
            starts.append(full * np.clip(path[nodes], 0.01, 0.99))
        return data, starts

    def parameters(self, data):
        weights = np.zeros(len(self.variables) + 1)
        for name, w in self.cost.items():
            if name in self.names:
                i = self.names.index(name); v = self.variables[i]
                whole = {"payload_mass_kg": self.total_kg, "payload_power_w": self.reference_w}.get(name, 0.0)
                weights[i] = w * (self.scales[i] / max(self.scales[i], 0.1 * whole) if v.linear else 1.0)
            else: weights[-1] = w
        self.weights = weights
        tech = [parameter_value(self.aircraft, None, k) for k in self.program.technology]
        b = self.aircraft.battery
        return np.concatenate([weights, np.array(self.conditions, float), np.array(tech, float), [b.mean_charge_efficiency, b.mean_discharge_efficiency], self.scales, self.centre, [self.reference_w, PRICE], *[np.concatenate([np.ravel(f) for f in d]) for d in data]])

    def bounds(self):
        low, high = [], []
        for v, sc in zip(self.variables, self.scales):
            l, h = v.minimum, v.maximum
            if v.role is Role.payload and v.name not in self.free: l = h = self.held[v.name]
            low.append(v.to_program(l, sc)); high.append(v.to_program(h, sc) if math.isfinite(h) else math.inf)
        p = self.program.parts; n = p["charge"].stop
        lo, hi = np.zeros(n), np.full(n, np.inf)
        lo[p["design"]], hi[p["design"]] = low, high
        goal = 0.0 if self.all_continuous else self.required_h
        lo[p["excess"]], hi[p["excess"]] = goal, 1e4 if self.best_excess else goal
        return lo, hi

    def begin(self):
        rank = {"min_mass": lambda d: np.asarray(d.total_mass_kg), "min_wingspan": lambda d: np.asarray(d.variables.wingspan_m)}.get(self.objective.value)
        with np.errstate(all="ignore"):
            start = most_promising(self.aircraft, self.mission, self.day, self.required_h, rank)
        values = {**self.held, OWN: 0.0} | {k: float(v) for k, v in start.chosen().items()}
        perf = self.fly(DesignVariables(**{k: np.array([v]) for k, v in self.design_variables(values).chosen().items()}))
        mass = float(np.asarray(perf.design.total_mass_kg)[0])
        values[TOTAL_MASS] = mass if np.isfinite(mass) else 3 * values["battery_mass_kg"]
        return values

    def run(self, rounds=12, verbose=False):
        t0 = time.process_time()
        values = self.begin()
        self.t_grid = time.process_time() - t0
        self.shift = np.zeros(self.count); self.margin = np.full(self.count, FIRST_MARGIN)
        self.nodes = {}; self.dawn = {}; self.slope = np.zeros((self.count, len(self.variables)))
        chosen = None; best = None; sol = None; elastic = None; last = None
        self.nearest = values; self.status = "not_converged"; stuck = 0
        for r in range(rounds):
            perf = self.batch(values)
            excess = np.array(np.asarray(perf.cycle.excess_time_h)[0], float)
            nominal = np.broadcast_to(np.asarray(perf.nominal_load_w), np.asarray(perf.cycle.excess_time_h).shape)[0]
            flies = nominal[0] < 1e11
            mass = float(np.asarray(perf.design.total_mass_kg)[0])
            lit = np.array(sorted(self.continuous), int)
            spare = (self.lowest[lit] * float(np.asarray(perf.design.variables.module_area_m2)[0]) / nominal[lit] - 1.0).min() if len(lit) else 0.0
            w = int(np.argmin(excess))
            meets = bool(np.ravel(meets_requirements(self.aircraft, self.mission, perf.design))[0])
            ok = meets and excess[w] > 0 and excess[w] >= self.required_h
            val = self.value(perf)
            if verbose: print(f"  {r} {'' if sol is None else ('E' if elastic else 'F')} {0 if sol is None else sol.iterations} {'' if sol is None else sol.status} lack {-1 if sol is None else sol.lack:.1e} T {0 if sol is None else sol.part('excess')[0]:.3f} sim {excess[w]:.4f} ({w}) meets {meets} val {val:.5f} mass {values[TOTAL_MASS]:.3f}/{mass:.3f} chosen {chosen}", flush=True)
            better = ok and (best is None or (val > best[0] if self.objective.maximised else val < best[0]))
            if ok and best is not None and not better and sol is not None and sol.lack < 1e-6: stuck += 1
            if better:
                gain = np.inf if best is None else abs(val - best[0]) / max(abs(best[0]), 1e-3)
                best = (val, values, excess[w])
                if gain < 2e-4: stuck += 1
            if sol is not None:
                if sol.lack > 1e-4:
                    if sol.lack > 0.03 and r >= 2 or r >= 5: self.status = "infeasible"; break
                else:
                    worth = self.worth(sol)
                    moved_little = max(abs(np.log(values[n] / before[n])) for n in self.free if values[n] > 0 and before[n] > 0) < 0.05
                    if ok and w in chosen and moved_little and (self.all_continuous or (not self.best_excess and (excess[w] - self.required_h) * worth < 3e-4)): break
                    if stuck >= 2 and ok: break
                goal = float(sol.part("excess")[0])
                for s in chosen:
                    if s in self.continuous: continue
                    T = excess[s]
                    if abs(goal - T) > 0.3: self.nodes.pop(s, None)
                    prog = goal + self.shift[s] - float(sol.part("lack")[chosen.index(s)]) * (8 + goal)
                    active = T < self.required_h + 1.0 if not self.best_excess else False
                    if T > 0 and np.isfinite(T):
                        if active or T < self.required_h:
                            # only where the program holds it back
                            if self.active(sol, chosen.index(s)):
                                self.shift[s] = prog - T + CUSHION_H
                            elif T < self.required_h: self.shift[s] += self.required_h - T + CUSHION_H
                    elif sol.lack <= 1e-4:
                        moved = max(abs(np.log(values[n] / before[n])) for n in self.free if values[n] > 0 and before[n] > 0)
                        if moved < 0.01: self.margin[s] *= 3
            if chosen is None: chosen = [int(i) for i in np.argsort(excess, kind="stable")[: self.blocks]]
            elif w not in chosen:
                chosen[int(np.argmax(excess[chosen]))] = w
            if not flies and sol is not None: pass
            if not np.isfinite(mass) or nominal[0] > 1e11:
                # no flight: fall back to the data at a mass that is assumed
                perf = self.assumed(values)
                if perf is None: self.status = "infeasible"; break
            else: values = values | {TOTAL_MASS: mass}
            self.scales = scales_of(self.variables, values)
            data, starts = self.data_of(perf, chosen)
            self.centre = np.array([v.to_program(min(max(values[v.name], v.minimum), v.maximum), sc) for v, sc in zip(self.variables, self.scales)])
            p = self.program.parts
            s0 = np.zeros(p["charge"].stop)
            s0[p["design"]] = self.centre
            T0 = min(max(float(excess.min()), self.required_h), 1e3) if self.best_excess else self.required_h
            s0[p["excess"]] = T0; s0[p["missed"]] = s0[p["lack"]] = 0.01
            s0[p["charge"]] = np.concatenate(starts)
            par, b = self.parameters(data), self.bounds()
            elastic = not (ok or (sol is not None and sol.lack < 1e-4)) 
            sol = solve(self.program, parameters=par, bounds=b, start=s0, elastic=elastic); self.solves += 1; self.iterations += sol.iterations
            if not elastic and not sol.converged:
                elastic = True
                sol = solve(self.program, parameters=par, bounds=b, start=s0, elastic=True); self.solves += 1; self.iterations += sol.iterations
            E = sol.part("charge").reshape(self.blocks, -1); full = self.full_of(sol, values)
            for i, s in enumerate(chosen): self.dawn[s] = min(max(E[i, 0] / E[i].max(), 0.01), 1.0)
            x = sol.part("design"); self.solved_scales = self.scales; self.par = par; before = values
            values = {v.name: float(v.from_program(one, sc)) for v, one, sc in zip(self.variables, x, self.scales)}
        if best is not None: self.status = "optimal"
        self.best = best; self.sol = sol
        return best, sol

    def active(self, sol, block):
        c = self.program.constraints
        lam = sum(abs(l) for l, k in zip(sol.lam_g, c) if k.block == block and k.name == "excess_time")
        return lam > 1e-4

    def full_of(self, sol, values): return 1.0

    def worth(self, sol):
        """Relative objective per hour of excess time."""
        lam = sum(abs(l) for l, k in zip(sol.lam_g, self.program.constraints) if k.name == "excess_time") / RESERVE_SCALE_H
        return lam / max(abs(sol.part("design") @ self.weights[:-1]) if self.objective.payload_key else 1.0, 1e-3)

    def assumed(self, values):
        return None

    def value(self, perf):
        from sizing.optimisation.result import objective_value
        v = np.ravel(objective_value(self.objective, perf))
        return float(v[0])
