/* Runs a unit as a simulator would: loads its library, and goes through rows of inputs from stdin to rows of states on stdout.
 *
 *   host LIBRARY GUID INPUTS STEP_S HELD U V R PARAMETERS
 *
 * Every row is held for HELD steps of the model, done at once. At the end steps of half and of one and a half are asked for; what
 * the unit says goes to stderr. */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void logger(void *environment, const char *name, int status, const char *category, const char *format, ...)
{
    va_list more;
    (void)environment;
    fprintf(stderr, "%s %d %s: ", name, status, category);
    va_start(more, format);
    vfprintf(stderr, format, more);
    va_end(more);
    fprintf(stderr, "\n");
}

static void *library;

static void *function(const char *name)
{
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "no %s\n", name);
        exit(9);
    }
    return found;
}

static void must(int status)
{
    if (status != 0) {
        fprintf(stderr, "status %d\n", status);
        exit(8);
    }
}

int main(int count, char **words)
{
    static const unsigned states[3] = {0, 1, 2};
    Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    int (*setup)(Component, int, double, double, int, double), (*enter)(Component), (*leave)(Component);
    int (*set)(Component, const unsigned *, size_t, const double *), (*get)(Component, const unsigned *, size_t, double *);
    int (*step)(Component, double, double, int), (*flag)(Component, const unsigned *, size_t, int *);
    int (*reset)(Component), inputs, held, within, i;
    unsigned places[64];
    double step_s, x[3], row[64], t = 0.0;
    Component unit;
    if (count != 10 || !(library = dlopen(words[1], RTLD_NOW))) {
        fprintf(stderr, "no library: %s\n", count == 10 ? dlerror() : "arguments");
        return 9;
    }
    instantiate = function("fmi2Instantiate");
    setup = function("fmi2SetupExperiment");
    enter = function("fmi2EnterInitializationMode");
    leave = function("fmi2ExitInitializationMode");
    set = function("fmi2SetReal");
    get = function("fmi2GetReal");
    flag = function("fmi2GetBoolean");
    step = function("fmi2DoStep");
    reset = function("fmi2Reset");
    inputs = atoi(words[3]);
    step_s = atof(words[4]);
    held = atoi(words[5]);
    if (instantiate("other", 1, "another guid", NULL, &callbacks, 0, 0)) {
        return 7;
    }
    unit = instantiate("ship", 1, words[2], NULL, &callbacks, 0, 0);
    if (!unit) {
        return 6;
    }
    must(reset(unit));
    must(setup(unit, 0, 0.0, 0.0, 0, 0.0));
    must(enter(unit));
    for (i = 0; i < 3; i++) {
        /* Initial states stand after the parameters. */
        const unsigned place = (unsigned)(3 + inputs + atoi(words[9]) + i);
        x[i] = atof(words[6 + i]);
        must(set(unit, &place, 1, x + i));
    }
    must(leave(unit));
    for (i = 0; i < inputs; i++) {
        places[i] = (unsigned)(3 + i);
    }
    must(get(unit, states, 3, x));
    printf("%.17g,%.17g,%.17g\n", x[0], x[1], x[2]);
    for (;;) {
        for (i = 0; i < inputs; i++) {
            if (scanf(i == 0 ? "%lf" : ",%lf", row + i) != 1) {
                const double more = 1.5 * step_s, less = 0.5 * step_s;
                fprintf(stderr, "half: %d\n", step(unit, t, less, 0));
                fprintf(stderr, "more: %d\n", step(unit, t, more, 0));
                must(flag(unit, (const unsigned[]){0}, 1, &within));
                fprintf(stderr, "within: %d\n", within);
                return 0;
            }
        }
        must(set(unit, places, (size_t)inputs, row));
        must(step(unit, t, held * step_s, 0));
        t += held * step_s;
        must(get(unit, states, 3, x));
        printf("%.17g,%.17g,%.17g\n", x[0], x[1], x[2]);
    }
}
