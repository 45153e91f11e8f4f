void {{base}}_step(const double *state, const double *input, const double *parameters, double *next)
{
    /* Of what the states have gained after one, two, ... own steps. */
    static const double weights[] = { {{weights}} };
    const double start[3] = {state[0], state[1], state[2]};
    double here[3] = {state[0], state[1], state[2]};
    double gained[3] = {0.0, 0.0, 0.0};
    size_t k;
    int d;
    for (k = 0; k < sizeof weights / sizeof *weights; k++) {
        own_step(here, input, parameters, here);
        for (d = 0; d < 3; d++) {
            gained[d] += (here[d] - start[d]) * weights[k];
        }
    }
    for (d = 0; d < 3; d++) {
        next[d] = start[d] + gained[d];
    }
}

