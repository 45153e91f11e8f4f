{{header}}
/* The functions of FMI 2.0 for co-simulation over the model's own step. The declarations are those of the standard that it
 * needs, so that nothing else has to be there to compile it. */
#include "{{base}}.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Byte;
typedef const char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

/* Value references: states, inputs, parameters, initial states. */
#define INPUTS {{BASE}}_STATES
#define PARAMETERS (INPUTS + {{BASE}}_INPUTS)
#define INITIAL (PARAMETERS + {{BASE}}_PARAMETERS)
#define REALS (INITIAL + {{BASE}}_STATES)

/* How far from a whole number of steps a communication step may be. */
#define TOLERANCE 1e-6

static const char GUID[] = {{guid}};
static const double INITIAL_STATES[] = { {{initial_states}} };
static const double INITIAL_INPUTS[] = { {{initial_inputs}} };

typedef struct {
    fmi2CallbackFunctions callbacks;
    char name[256];
    int running;
    int told_outside;
    double samples; /* how many steps were done */
    double start_s;
    double reals[REALS];
} Instance;

static void tell(const Instance *own, fmi2Status status, const char *category, const char *format, ...)
{
    char text[512];
    va_list more;
    if (!own->callbacks.logger) {
        return;
    }
    va_start(more, format);
    vsnprintf(text, sizeof text, format, more);
    va_end(more);
    own->callbacks.logger(own->callbacks.componentEnvironment, own->name, status, category, "%s", text);
}

static fmi2Status refuse(const Instance *own, const char *what)
{
    tell(own, fmi2Error, "logStatusError", "%s", what);
    return fmi2Error;
}

static void restart(Instance *own)
{
    int i;
    own->running = 0;
    own->told_outside = 0;
    own->samples = 0.0;
    own->start_s = 0.0;
    for (i = 0; i < {{BASE}}_STATES; i++) {
        own->reals[i] = own->reals[INITIAL + i] = INITIAL_STATES[i];
    }
    for (i = 0; i < {{BASE}}_INPUTS; i++) {
        own->reals[INPUTS + i] = INITIAL_INPUTS[i];
    }
    for (i = 0; i < {{BASE}}_PARAMETERS; i++) {
        own->reals[PARAMETERS + i] = {{base}}_values[i];
    }
}

EXPORTED const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

EXPORTED const char *fmi2GetVersion(void)
{
    return "2.0";
}

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    Instance *own = calloc(1, sizeof *own);
    (void)resources, (void)visible, (void)logging;
    if (!own) {
        return NULL;
    }
    if (callbacks) {
        own->callbacks = *callbacks;
    }
    snprintf(own->name, sizeof own->name, "%s", name ? name : "");
    if (type != fmi2CoSimulation) {
        refuse(own, "type: found model exchange, expected co-simulation; instantiate it as that");
    } else if (!guid || strcmp(guid, GUID) != 0) {
        refuse(own, "guid: found another than this unit's, expected that of its modelDescription.xml; read it again");
    } else {
        restart(own);
        return own;
    }
    free(own);
    return NULL;
}

EXPORTED void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start_s,
                                        fmi2Boolean stop_defined, fmi2Real stop_s)
{
    Instance *own = c;
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop_s;
    own->start_s = start_s;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *own = c;
    own->running = 1;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Reset(fmi2Component c)
{
    restart(c);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference places[], size_t count, fmi2Real values[])
{
    const Instance *own = c;
    size_t i;
    for (i = 0; i < count; i++) {
        if (places[i] >= REALS) {
            return refuse(own, "value reference: found none of this unit's; read its modelDescription.xml again");
        }
        values[i] = own->reals[places[i]];
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference places[], size_t count, const fmi2Real values[])
{
    Instance *own = c;
    size_t i;
    for (i = 0; i < count; i++) {
        if (places[i] < INPUTS || places[i] >= REALS) {
            return refuse(own, "value reference: found none that can be set, expected an input or parameter");
        }
        if (places[i] >= INITIAL && own->running) {
            return refuse(own, "initial state: found it set during a simulation, expected before; reset the unit");
        }
        own->reals[places[i]] = values[i];
        if (places[i] >= INITIAL) {
            own->reals[places[i] - INITIAL] = values[i];
        }
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference places[], size_t count, fmi2Boolean values[])
{
    const Instance *own = c;
    size_t i;
    for (i = 0; i < count; i++) {
        if (places[i] != 0) {
            return refuse(own, "value reference: found none of this unit's; read its modelDescription.xml again");
        }
        values[i] = {{base}}_within_ranges(own->reals, own->reals + INPUTS);
    }
    return fmi2OK;
}

/* A communication step is so many steps of the model; none of another length can be done. Inputs are held meanwhile. */
EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now_s, fmi2Real length_s, fmi2Boolean no_way_back)
{
    Instance *own = c;
    const double samples = length_s * {{BASE}}_SAMPLE_RATE_HZ;
    const double whole = floor(samples + 0.5);
    double k;
    int outside;
    (void)now_s, (void)no_way_back;
    if (!own->running) {
        return refuse(own, "step: found the unit not initialized, expected that before; call fmi2ExitInitializationMode");
    }
    if (!(whole >= 1.0 && whole < 1e9 && fabs(samples - whole) <= TOLERANCE)) {
        tell(own, fmi2Error, "logStatusError",
             "communication step: found %.17g s, expected a whole number of the model's steps of %.17g s; for others, export "
             "the model by --rate",
             length_s, {{BASE}}_STEP_S);
        return fmi2Error;
    }
    for (k = 0.0; k < whole; k += 1.0) {
        outside = {{base}}_outside(own->reals, own->reals + INPUTS);
        if (outside >= 0 && !own->told_outside) {
            const {{base}}_range *range = {{base}}_ranges + outside;
            const double *value = own->reals + range->channel;
            own->told_outside = 1;
            tell(own, fmi2Warning, "logStatusWarning", "%s: found %g, expected %g to %g, {{ranges_are}}; told once",
                 {{base}}_channels[range->channel].identifier, *value, range->low, range->high);
        }
        {{base}}_step(own->reals, own->reals + INPUTS, own->reals + PARAMETERS, own->reals);
        own->samples += 1.0;
        if (!isfinite(own->reals[0]) || !isfinite(own->reals[1]) || !isfinite(own->reals[2])) {
            tell(own, fmi2Error, "logStatusError",
                 "state: found no finite number after %.17g s, expected one; keep inputs within the range of validity",
                 own->start_s + own->samples * {{BASE}}_STEP_S);
            return fmi2Error;
        }
    }
    return fmi2OK;
}

/* What the standard wants to be there, and this unit has not. */

EXPORTED fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference places[], size_t count, fmi2Integer values[])
{
    (void)places, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "integer: found no such variable");
}

EXPORTED fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference places[], size_t count, fmi2String values[])
{
    (void)places, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "string: found no such variable");
}

EXPORTED fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference places[], size_t count,
                                   const fmi2Integer values[])
{
    (void)places, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "integer: found no such variable");
}

EXPORTED fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference places[], size_t count,
                                   const fmi2Boolean values[])
{
    (void)places, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "boolean: found none that can be set");
}

EXPORTED fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference places[], size_t count, const fmi2String values[])
{
    (void)places, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "string: found no such variable");
}

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)state;
    return refuse(c, "state of the unit: it cannot be kept");
}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    (void)state;
    return refuse(c, "state of the unit: it cannot be kept");
}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)state;
    return refuse(c, "state of the unit: it cannot be kept");
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)state, (void)size;
    return refuse(c, "state of the unit: it cannot be kept");
}

EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    (void)state, (void)bytes, (void)size;
    return refuse(c, "state of the unit: it cannot be kept");
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    (void)bytes, (void)size, (void)state;
    return refuse(c, "state of the unit: it cannot be kept");
}

EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                                 const fmi2ValueReference known[], size_t knowns, const fmi2Real by[],
                                                 fmi2Real of[])
{
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)by, (void)of;
    return refuse(c, "directional derivative: there is none");
}

EXPORTED fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference places[], size_t count,
                                                const fmi2Integer orders[], const fmi2Real values[])
{
    (void)places, (void)orders, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "derivatives of inputs: inputs are held");
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference places[], size_t count,
                                                 const fmi2Integer orders[], fmi2Real values[])
{
    (void)places, (void)orders, (void)values;
    return count == 0 ? fmi2OK : refuse(c, "derivatives of outputs: there are none");
}

EXPORTED fmi2Status fmi2CancelStep(fmi2Component c)
{
    return refuse(c, "step: found none to cancel");
}

EXPORTED fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return refuse(c, "status: steps are done at once");
}

EXPORTED fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    const Instance *own = c;
    if (kind != fmi2LastSuccessfulTime) {
        return refuse(own, "status: steps are done at once");
    }
    *value = own->start_s + own->samples * {{BASE}}_STEP_S;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return refuse(c, "status: steps are done at once");
}

EXPORTED fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated) {
        return refuse(c, "status: steps are done at once");
    }
    *value = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return refuse(c, "status: steps are done at once");
}
