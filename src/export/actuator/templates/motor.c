@HEADER@
#include <math.h>
#include <string.h>

@CONSTANTS@
enum { N_STATE = @STATE@, N_MODE = @MODE@, N_EVENTS = @EVENTS@, N_HISTORY = @HISTORY@ };
/* Events located within one inner step; later ones are applied at its end. */
enum { MOST_EVENTS = 8 };
/* Iterations that locate an event. */
enum { REFINED = 6 };

/* The state: y has @NAMES@. All zeros is at rest. */
typedef struct {
    double y[N_STATE];
    double load_nm;             /* N m: external torque on the output shaft, an input */
    double history[N_HISTORY];  /* V: delayed commands, the newest last */
} motor_state;

static inline double pick(int condition, double a, double b) { return condition ? a : b; }
static inline double sgn(double x) { return (x > 0.0) - (x < 0.0); }
static inline double command(double u) { return @COMMAND@; }

@FUNCTIONS@
/* One Runge-Kutta step of fourth order within a mode. */
static void runge_kutta(const double *y, const double *m, double span_s, double *end)
{
    double a[N_STATE], b[N_STATE], c[N_STATE], d[N_STATE], at[N_STATE];
    int j;
    rates(y, m, a);
    for (j = 0; j < N_STATE; j++) at[j] = y[j] + 0.5 * span_s * a[j];
    rates(at, m, b);
    for (j = 0; j < N_STATE; j++) at[j] = y[j] + 0.5 * span_s * b[j];
    rates(at, m, c);
    for (j = 0; j < N_STATE; j++) at[j] = y[j] + span_s * c[j];
    rates(at, m, d);
    for (j = 0; j < N_STATE; j++) end[j] = y[j] + span_s / 6.0 * (a[j] + 2.0 * b[j] + 2.0 * c[j] + d[j]);
}

/* One inner step, divided at events. */
static void inner(double *y, double u, double load, double span_s)
{
    double m[N_MODE], before[N_EVENTS], after[N_EVENTS], end[N_STATE];
    int n;
    for (n = 1; n <= MOST_EVENTS; n++) {
        int k = -1, j;
        double share = 1.0;
        mode(y, u, load, m);
        events(y, m, before);
        runge_kutta(y, m, span_s, end);
        events(end, m, after);
        for (j = 0; j < N_EVENTS; j++) {
            if (after[j] < 0.0 && after[j] < before[j]) {
                const double at = before[j] > 0.0 ? before[j] / (before[j] - after[j]) : 0.0;
                if (k < 0 || at < share) {
                    k = j;
                    share = at;
                }
            }
        }
        if (k >= 0 && n < MOST_EVENTS) {
            /* False position, or bisection from an event at the start: it lies between early and late. */
            double early = 0.0, late = 1.0, value_early = before[k], value_late = after[k];
            for (j = 0; j < REFINED; j++) {
                share = early + (late - early) * (value_early > 0.0 ? value_early / (value_early - value_late) : 0.5);
                runge_kutta(y, m, share * span_s, end);
                events(end, m, after);
                if (after[k] <= 0.0) {
                    late = share;
                    value_late = after[k];
                }
                if (after[k] >= 0.0) {
                    early = share;
                    value_early = after[k];
                }
            }
        }
        snap(end, m, k, y);
        if (k < 0) return;
        span_s *= 1.0 - share;
    }
}

/* Advances with a voltage held. */
static void hold(double *y, double u, double load, double span_s)
{
    const int steps = (int)ceil(span_s / INNER_S - 1e-9);
    int n;
    for (n = 0; n < steps; n++) inner(y, u, load, span_s / steps);
}

/* At rest at angle 0. */
void motor_start(motor_state *s) { memset(s, 0, sizeof *s); }

/* Holds a voltage (V) for STEP_S and returns the mean torque (N m) on the output shaft, whose inertia is OUTPUT_INERTIA_KG_M2. */
double motor_step(motor_state *s, double voltage)
{
    const double before = s->y[@OUTPUT@ + 1];
    memmove(s->history, s->history + 1, (N_HISTORY - 1) * sizeof s->history[0]);
    s->history[N_HISTORY - 1] = voltage;
    hold(s->y, command(s->history[0]), s->load_nm, LATE_S);
    hold(s->y, command(s->history[1]), s->load_nm, STEP_S - LATE_S);
    return OUTPUT_INERTIA_KG_M2 * (s->y[@OUTPUT@ + 1] - before) / STEP_S - s->load_nm;
}

/* Angle (rad) and speed (rad/s) of the output shaft, and the angle that the encoder sees. */
double motor_angle(const motor_state *s) { return s->y[@OUTPUT@]; }
double motor_speed(const motor_state *s) { return s->y[@OUTPUT@ + 1]; }
double motor_encoder_angle(const motor_state *s) { return s->y[@ENCODER@]; }
