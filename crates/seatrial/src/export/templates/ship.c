/* Steps of Runge and Kutta's method in a sample. */
#define {{BASE}}_STEPS {{steps}}

{{routines}}/* The state `seconds` later by a step of order 4, while the inputs are held; `next` may be `state`. */
static void runge_kutta(const double *state, const double *input, double seconds, const double *p, double *next)
{
    static const double shares[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weights[4] = {1.0, 2.0, 2.0, 1.0};
    double here[3];
    double rates[3] = {0.0, 0.0, 0.0};
    double total[3] = {0.0, 0.0, 0.0};
    int stage, d;
    for (stage = 0; stage < 4; stage++) {
        for (d = 0; d < 3; d++) {
            here[d] = state[d] + rates[d] * (shares[stage] * seconds);
        }
        accelerations(here, input, p, rates);
        for (d = 0; d < 3; d++) {
            total[d] += rates[d] * weights[stage];
        }
    }
    for (d = 0; d < 3; d++) {
        next[d] = state[d] + total[d] * (seconds / 6.0);
    }
}

void {{base}}_step(const double *state, const double *input, const double *parameters, double *next)
{
    const double *p = parameters ? parameters : {{base}}_values;
    int i;
    runge_kutta(state, input, {{BASE}}_STEP_S / {{BASE}}_STEPS, p, next);
    for (i = 1; i < {{BASE}}_STEPS; i++) {
        runge_kutta(next, input, {{BASE}}_STEP_S / {{BASE}}_STEPS, p, next);
    }
}

