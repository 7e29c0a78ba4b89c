/* A feasibility map in plain C: the bound that benchmarks/map_scaling.py measures the map against.

   The same arithmetic as solar/power.py (CAM) and sizing/cycle.py, cell by cell on one thread:
   power of the half day with its mirror image, surplus and deficit of every interval, the repeated
   day from the same start, and all metrics of the map. No thermals: the load is constant. */

#include <math.h>

typedef struct {
    int nodes, half, pieces, clock_nodes;
    const double *time_h, *cos_hour;                 /* nodes; half */
    const double *curve_begin, *curve_end, *cubic;   /* pieces; pieces; 4 x pieces */
    const double *clock_soc, *clock_h;               /* clock_nodes */
    double pressure, common, camber, diffuse, first_angle, last_angle;
    double area_m2, load_w, battery_energy_wh, eta_charge, eta_discharge;
    double constant_up_to, constant_rate_per_h;
} Craft;

enum { EXCESS, SOC, MARGIN, MORNING, EVENING, FULL, SOLAR, LOAD, STATUS, METRICS };
enum { LIMITED, PERPETUAL, ALWAYS_LIT, NEVER_LIT };

static double positive(double x) { return x > 0.0 ? x : 0.0; }

static double clamp(double x, double low, double high) { return fmin(fmax(x, low), high); }

/* Linear interpolation; the place found last is where the search begins. */
static double interpolate(const double *x, const double *y, int n, double at, int *place) {
    int i = *place;
    if (at >= x[n - 1]) return y[n - 1];
    if (at <= x[0]) return y[0];
    while (x[i] > at) i--;
    while (x[i + 1] <= at) i++;
    *place = i;
    return y[i] + (y[i + 1] - y[i]) / (x[i + 1] - x[i]) * (at - x[i]);
}

static double incidence(const Craft *c, double cosine) {
    double angle = clamp(acos(fmin(cosine, 1.0)) * (180.0 / M_PI), c->first_angle, c->last_angle);
    int i = 0;
    while (angle >= c->curve_end[i]) i++;
    double along = angle - c->curve_begin[i], value = c->cubic[i];
    for (int k = 1; k < 4; k++) value = value * along + c->cubic[k * c->pieces + i];
    return value;
}

static double ramp(double left, double right, double share) {
    double goal = clamp(share, 0.0, 1.0) * (left + right) / 2.0;
    double root = sqrt(positive(left * left + 2.0 * (right - left) * goal));
    return clamp(2.0 * goal / fmax(left + root, 1e-300), 0.0, 1.0);
}

static double charged(const Craft *c, double energy, double surplus, double hours, int place[2]) {
    double target = fmin(energy + c->eta_charge * surplus, c->battery_energy_wh);
    double after = fmin(target, energy + c->constant_rate_per_h * c->battery_energy_wh * hours);
    if (after <= fmax(energy, c->constant_up_to * c->battery_energy_wh)) return after;
    double begun = interpolate(c->clock_soc, c->clock_h, c->clock_nodes,
                               fmin(energy / c->battery_energy_wh, 1.0), &place[0]);
    double limited = c->battery_energy_wh * interpolate(c->clock_h, c->clock_soc, c->clock_nodes,
                                              begun + hours, &place[1]);
    return fmax(fmin(target, limited), energy);
}

static void cell(const Craft *c, double mean, double amplitude, double a, double b, double diffuse,
                 double outside, double *solar, double *net, double *surplus, double *deficit, double *out) {
    const int n = c->nodes - 1;
    for (int k = 0; k < c->half; k++) {
        double cosine = mean + amplitude * c->cos_hour[k], power = 0.0;
        if (cosine > 0.0) {
            double dni = a * exp(-b * c->pressure * 35.0 / sqrt(1224.0 * cosine * cosine + 1.0));
            double direct = dni * cosine * incidence(c, cosine) * c->camber;
            double scattered = fmin(diffuse * dni, (outside - dni) * cosine);
            power = c->area_m2 * (direct + scattered * c->diffuse) * c->common;
        }
        solar[k] = solar[n - k] = power;
        net[k] = net[n - k] = power - c->load_w;
    }
    double solar_wh = 0.0, gained = 0.0, lost = 0.0, tail = 0.0;
    double morning = NAN, evening = NAN;
    int always = 1, rise = -1;
    for (int k = 0; k < n; k++) {
        double hours = c->time_h[k + 1] - c->time_h[k], l = net[k], r = net[k + 1];
        double up = positive(l) + positive(r), down = positive(-l) + positive(-r);
        double scale = hours / fmax(2.0 * (up + down), 1e-300);
        surplus[k] = up * up * scale;
        deficit[k] = down * down * scale;
        solar_wh += (solar[k] + solar[k + 1]) / 2.0 * hours;
        gained += surplus[k];
        lost += deficit[k];
        tail = surplus[k] > 0.0 ? (l < 0.0 ? 0.0 : deficit[k]) : tail + deficit[k];
        always &= l >= 0.0 && r >= 0.0;
        double fraction = l == r ? 0.0 : clamp(l / (l - r), 0.0, 1.0);
        if (l < 0.0 && r >= 0.0 && rise < 0) {
            rise = k;
            morning = c->time_h[k] + fraction * hours;
        }
        if (l >= 0.0 && r < 0.0) evening = c->time_h[k] + fraction * hours;
    }
    double start = 0.0, lowest, dawn, first, last, missing, unserved;
    if (c->eta_charge * gained * c->eta_discharge >= lost)
        start = positive(c->battery_energy_wh - tail / c->eta_discharge);
    for (int cycle = 0; cycle < 400; cycle++) {
        int place[2] = {0, 0};
        double energy = start;
        lowest = INFINITY;
        dawn = missing = unserved = 0.0;
        first = last = NAN;
        for (int k = 0; k < n; k++) {
            double hours = c->time_h[k + 1] - c->time_h[k], l = net[k], r = net[k + 1];
            double crossing = l == r ? 0.0 : hours * clamp(l / (l - r), 0.0, 1.0);
            double before = energy, drained = energy;
            if (l < 0.0) drained -= deficit[k] / c->eta_discharge;
            before = positive(drained);
            if (k == rise) dawn = before;
            double after = before;
            if (surplus[k] > 0.0) {
                after = charged(c, before, surplus[k], hours, place);
                if (after >= (1.0 - 1e-9) * c->battery_energy_wh) {
                    double begin = l < 0.0 ? crossing : 0.0, end = r < 0.0 ? crossing : hours;
                    if (isnan(first)) {
                        double share = (c->battery_energy_wh - before) / (c->eta_charge * surplus[k]);
                        double taken = (end - begin) * ramp(positive(l), positive(r), share);
                        double from = interpolate(c->clock_soc, c->clock_h, c->clock_nodes,
                                                  fmin(before / c->battery_energy_wh, 1.0), &place[0]);
                        taken = fmax(taken, c->clock_h[c->clock_nodes - 1] - from);
                        first = c->time_h[k] + fmin(begin + taken, end);
                    }
                    last = c->time_h[k] + end;
                }
            }
            double left = after;
            if (l >= 0.0) left -= deficit[k] / c->eta_discharge;
            energy = positive(left);
            lowest = fmin(lowest, fmin(before, energy));
            double lack = c->eta_discharge * (before - drained + energy - left);
            if (lack > 0.0) {
                double length = l < 0.0 ? (r < 0.0 ? hours : crossing) : hours - crossing;
                missing += length * (1.0 - ramp(positive(-l), positive(-r), 1.0 - lack / deficit[k]));
                unserved += lack;
            }
        }
        double moved = fabs(energy - start);
        start = energy;
        if (moved <= 1e-11 * c->battery_energy_wh) break;
    }
    int starved = unserved > 1e-9 * c->battery_energy_wh, dark = isnan(morning) && !always;
    double excess = starved || dark ? -missing : dawn * c->eta_discharge / c->load_w;
    if (always && !starved) excess = INFINITY;
    out[EXCESS] = excess;
    out[SOC] = excess > 0.0 ? lowest / c->battery_energy_wh : 0.0;
    out[MARGIN] = isnan(first) ? 0.0 : last - first;
    out[MORNING] = morning;
    out[EVENING] = evening;
    out[FULL] = first;
    out[SOLAR] = solar_wh;
    out[LOAD] = c->load_w * 24.0;
    out[STATUS] = solar_wh <= 0.0 ? NEVER_LIT
                  : always && !starved ? ALWAYS_LIT
                  : excess > 0.0 ? PERPETUAL : LIMITED;
}

/* skies: mean and amplitude of the sun's arc, A, B and C of the clear sky and the
   light outside the atmosphere, for every cell.
   work: four times the nodes. result: METRICS values for every cell. */
void map_cells(const Craft *craft, int cells, const double *skies, double *work, double *result) {
    const int n = craft->nodes;
    for (int i = 0; i < cells; i++) {
        const double *s = skies + 6 * i;
        cell(craft, s[0], s[1], s[2], s[3], s[4], s[5], work, work + n, work + 2 * n, work + 3 * n,
             result + METRICS * i);
    }
}
