{{header}}
/* C99. Compile with -ffp-contract=off for the same bits as the program that wrote it; without, last digits may differ. */
#include "{{base}}.h"

#include <math.h>

const char {{base}}_vessel[] = {{vessel}};
const char {{base}}_made_from[] = {{made_from}};

const {{base}}_channel {{base}}_channels[{{BASE}}_STATES + {{BASE}}_INPUTS] = {
{{channels}}};

const {{base}}_parameter {{base}}_parameters[{{BASE}}_PARAMETERS] = {
{{parameters}}};

const double {{base}}_values[{{BASE}}_PARAMETERS] = {
{{values}}};

const {{base}}_range {{base}}_ranges[{{range_capacity}}] = {
{{ranges}}};

{{functions}}void {{base}}_simulate(const double *initial, const double *inputs, size_t samples, const double *parameters,
                       double *states)
{
    size_t k;
    for (k = 0; k < {{BASE}}_STATES; k++) {
        states[k] = initial[k];
    }
    for (k = 0; k < samples; k++) {
        const double *state = states + {{BASE}}_STATES * k;
        {{base}}_step(state, inputs + {{BASE}}_INPUTS * k, parameters, states + {{BASE}}_STATES * (k + 1));
    }
}

int {{base}}_outside(const double *state, const double *input)
{
    int i;
    for (i = 0; i < {{BASE}}_RANGES; i++) {
        const {{base}}_range *range = {{base}}_ranges + i;
        const double value =
            range->channel < {{BASE}}_STATES ? state[range->channel] : input[range->channel - {{BASE}}_STATES];
        /* Written so that what is no number is outside. */
        if (!(range->low <= value && value <= range->high)) {
            return i;
        }
    }
    return -1;
}

int {{base}}_within_ranges(const double *state, const double *input)
{
    return {{base}}_outside(state, input) < 0;
}
