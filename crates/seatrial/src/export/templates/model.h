{{header}}
#ifndef {{BASE}}_H
#define {{BASE}}_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* {{rate_holds}} [Hz] */
#define {{BASE}}_SAMPLE_RATE_HZ {{rate}}
/* The length of a step [s]. */
#define {{BASE}}_STEP_S (1.0 / {{BASE}}_SAMPLE_RATE_HZ)

/* u, v, r */
#define {{BASE}}_STATES 3

/* Inputs and measured disturbances, and their places in a row of inputs. */
#define {{BASE}}_INPUTS {{input_count}}
{{input_places}}
/* Parameters, and their places. */
#define {{BASE}}_PARAMETERS {{parameter_count}}
{{parameter_places}}
/* How many ranges of validity are known. */
#define {{BASE}}_RANGES {{range_count}}

typedef struct {
    const char *identifier;
    const char *name; /* as in the model's file */
    const char *unit;
} {{base}}_channel;

typedef struct {
    const char *identifier;
    const char *name; /* as in the model's file */
    const char *unit;
    double value;
    double standard_error; /* negative where it is not known */
} {{base}}_parameter;

/* Least and largest value of a channel: {{ranges_are}}. */
typedef struct {
    int channel; /* its place among the channels */
    double low;
    double high;
} {{base}}_range;

extern const char {{base}}_vessel[];
extern const char {{base}}_made_from[];
/* The states, then the inputs. */
extern const {{base}}_channel {{base}}_channels[{{BASE}}_STATES + {{BASE}}_INPUTS];
extern const {{base}}_parameter {{base}}_parameters[{{BASE}}_PARAMETERS];
/* The parameters' values alone, to be copied and changed. */
extern const double {{base}}_values[{{BASE}}_PARAMETERS];
extern const {{base}}_range {{base}}_ranges[{{range_capacity}}];

/* The state one sample after `state`, while the inputs are held. `parameters` may be NULL for those of the model; `next` may be
 * `state`. */
void {{base}}_step(const double *state, const double *input, const double *parameters, double *next);

/* `samples` rows of inputs to one more rows of states, the first of which is `initial`. */
void {{base}}_simulate(const double *initial, const double *inputs, size_t samples, const double *parameters,
                       double *states);

/* The place of the first range that state or inputs are outside of; -1 within all. */
int {{base}}_outside(const double *state, const double *input);

/* Whether state and inputs are within the range of validity. */
int {{base}}_within_ranges(const double *state, const double *input);

#ifdef __cplusplus
}
#endif

#endif
