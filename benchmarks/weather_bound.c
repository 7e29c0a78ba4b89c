/* A year of weather in plain C: the bound that benchmarks/weather_year.py measures a run against.

   The same arithmetic as sizing/energy/carried_days.py, one interval after the other on one thread:
   dawns, the charge carried over from day to day, days that close, and a flight from a full battery
   at every dawn until the battery is empty. A flight that is at some midnight where a later launch
   was before, to the last bit, shares the rest of its way, here as there. */

#include <math.h>

typedef struct {
    int days, intervals, clock_nodes;
    double step_h, eta_charge, eta_discharge, constant_up_to, constant_rate_per_h;
    const double *clock_soc, *clock_h;        /* clock_nodes */
    const double *net_w;                      /* days x (intervals + 1) */
    const double *full_wh, *noon_h;           /* days */
} Year;

typedef struct { double surplus, early, late; } Flow;

static const double SHORT = 1e-12;

static double positive(double x) { return x > 0.0 ? x : 0.0; }

static double interpolate(const double *x, const double *y, int n, double at) {
    if (at >= x[n - 1]) return y[n - 1];
    if (at <= x[0]) return y[0];
    int low = 0, high = n - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (x[middle] <= at) low = middle; else high = middle;
    }
    return y[low] + (y[low + 1] - y[low]) / (x[low + 1] - x[low]) * (at - x[low]);
}

static Flow flow(const Year *y, int day, int k) {
    const double *net = y->net_w + (long)day * (y->intervals + 1) + k;
    double above = positive(net[0]) + positive(net[1]);
    double below = positive(-net[0]) + positive(-net[1]);
    double total = fmax(2.0 * (above + below), 1e-300);
    Flow f = {above * above / total * y->step_h, 0.0, below * below / total * y->step_h};
    if (net[0] < 0.0) f.early = f.late, f.late = 0.0;
    return f;
}

static double crossing(double left, double right) {
    return fmin(fmax(left / (left - right), 0.0), 1.0);
}

static double charged(const Year *y, double energy, double full, double surplus) {
    double target = fmin(energy + y->eta_charge * surplus, full);
    double after = fmin(target, energy + y->constant_rate_per_h * full * y->step_h);
    if (after <= fmax(energy, y->constant_up_to * full)) return after;
    double begun = interpolate(y->clock_soc, y->clock_h, y->clock_nodes, fmin(energy / full, 1.0));
    double limited = full * interpolate(y->clock_h, y->clock_soc, y->clock_nodes, begun + y->step_h);
    return fmax(fmin(target, limited), energy);
}

/* Interval in which a day's dawn is, and whether the interval's early deficit comes before it. */
static double dawn(const Year *y, int day, int *interval, int *after_deficit) {
    double charge = 0.0, least = INFINITY, hour = 0.0;
    int k = 0;
    for (; (k + 1) * y->step_h <= y->noon_h[day]; k++) {
        const double *net = y->net_w + (long)day * (y->intervals + 1) + k;
        Flow f = flow(y, day, k);
        double lowest = charge - f.early / y->eta_discharge;
        if (lowest < least) {
            int falls = net[0] < 0.0;
            double share = !falls ? 0.0 : net[1] < 0.0 ? 1.0 : crossing(net[0], net[1]);
            least = lowest, hour = (k + share) * y->step_h;
            *interval = k, *after_deficit = falls;
        }
        charge += y->eta_charge * f.surplus - (f.early + f.late) / y->eta_discharge;
    }
    if (charge < least) hour = k * y->step_h, *interval = k, *after_deficit = 0;
    return hour;
}

/* Hours into an interval at which a deficit of the battery's energy has been served. */
static double empty_h(const Year *y, int day, int k, double deficit, double served) {
    const double *net = y->net_w + (long)day * (y->intervals + 1) + k;
    double left = positive(-net[0]), right = positive(-net[1]), begin = 0.0, length = y->step_h;
    if (!(net[0] < 0.0)) begin = crossing(net[0], net[1]) * y->step_h, length -= begin;
    else if (!(net[1] < 0.0)) length *= crossing(net[0], net[1]);
    double goal = fmin(fmax(served / deficit, 0.0), 1.0) * (left + right) / 2.0;
    double root = sqrt(positive(left * left + 2.0 * (right - left) * goal));
    return begin + length * fmin(2.0 * goal / fmax(left + root, 1e-300), 1.0);
}

/* One flight; its end in hours since the record's begin, infinite if it outlasts the record. */
static double flight(const Year *y, int day, int k, int after_deficit, double *energy_at,
                     double *end_at) {
    double eta = y->eta_discharge, energy = y->full_wh[day], end = INFINITY;
    int first = day, d;
    for (d = day; d < y->days; d++, k = 0) {
        double full = y->full_wh[d];
        for (; k < y->intervals; k++, after_deficit = 0) {
            Flow f = flow(y, d, k);
            double deficits[2] = {after_deficit ? 0.0 : f.early, f.late};
            for (int part = 0; part < 2; part++) {
                double left = energy - deficits[part] / eta;
                if (left < -SHORT * full) {
                    end = 24.0 * d + k * y->step_h + empty_h(y, d, k, deficits[part], eta * energy);
                    goto landed;
                }
                energy = positive(left);
                if (part == 0) energy = charged(y, energy, full, f.surplus);
            }
        }
        if (d + 1 == y->days) break;
        energy *= y->full_wh[d + 1] / full;
        if (energy == energy_at[d + 1]) { end = end_at[d + 1]; break; }
        energy_at[d + 1] = energy;
        end_at[d + 1] = NAN;
    }
landed:
    for (d = first + 1; d < y->days; d++) if (isnan(end_at[d])) end_at[d] = end;
    return end;
}

void fly_year(const Year *y, double *dawn_h, int *closes, double *hours, double *work) {
    int n = y->days;
    double energy = y->full_wh[0], eta = y->eta_discharge;
    for (int day = 0; day < n; day++) {
        int at = 0, after_deficit = 0, before = 0, after = 0;
        double full = y->full_wh[day];
        dawn_h[day] = dawn(y, day, &at, &after_deficit);
        for (int k = 0; k < y->intervals; k++) {
            Flow f = flow(y, day, k);
            int early_before = k < at || (k == at && after_deficit);
            double left = energy - f.early / eta;
            if (left < -SHORT * full) { if (early_before) before = 1; else after = 1; }
            energy = charged(y, positive(left), full, f.surplus);
            left = energy - f.late / eta;
            if (left < -SHORT * full) { if (k < at) before = 1; else after = 1; }
            energy = positive(left);
        }
        closes[day] = !after;
        if (day && before) closes[day - 1] = 0;
        if (day + 1 < n) energy *= y->full_wh[day + 1] / full;
    }
    double *energy_at = work, *end_at = work + n;
    for (int d = 0; d < n; d++) energy_at[d] = -1.0, end_at[d] = 0.0;
    for (int day = n - 1; day >= 0; day--) {
        int at = 0, after_deficit = 0;
        dawn(y, day, &at, &after_deficit);
        double end = flight(y, day, at, after_deficit, energy_at, end_at);
        hours[day] = fmin(end, 24.0 * n) - 24.0 * day - dawn_h[day];
    }
}
