/* An oven as an FMU for co-simulation, by the functions of the standard alone: FMI 2.0, or with -DFMI3 3.0.
 *
 * It integrates dT/dt = (power - (temperature - ambient) * loss) / capacity in ten explicit steps of each communication
 * step. From `fail_at` on it goes wrong in the way that `fail_how` says. */

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#ifndef GUID
#define GUID "{oven}"
#endif

enum { OK, WARNING, DISCARD, ERROR, FATAL };
enum { TEMPERATURE, POWER, ENABLED, AMBIENT, CAPACITY, LOSS, HOT, STEPS, FAIL_AT, FAIL_HOW, COUNT };
enum { FAIL_ERROR = 1, FAIL_DISCARD, FAIL_FATAL, FAIL_NAN, FAIL_EARLY, FAIL_END, FAIL_START };

typedef struct {
    double value[COUNT];
    int has_begun;
    void *environment;
    void (*log)(void *, int, const char *);
} Oven;


static Oven *begin(void) {
    Oven *oven = calloc(1, sizeof *oven);
    oven->value[TEMPERATURE] = oven->value[AMBIENT] = 20;
    oven->value[CAPACITY] = 300;
    oven->value[LOSS] = 1;
    oven->value[FAIL_AT] = 1e9;
    return oven;
}

static int complain(Oven *oven, int status, const char *what) {
    if (oven->log) oven->log(oven->environment, status, what);
    return status;
}

static int step(Oven *oven, double from, double length) {
    double *v = oven->value;
    if (from + length > v[FAIL_AT]) {
        switch ((int)v[FAIL_HOW]) {
        case FAIL_ERROR: return complain(oven, ERROR, "the door is open");
        case FAIL_DISCARD: return complain(oven, DISCARD, "too long a step");
        case FAIL_FATAL: return complain(oven, FATAL, "on fire");
        case FAIL_NAN: v[TEMPERATURE] = NAN; return OK;
        }
    }
    double power = v[ENABLED] ? v[POWER] : 0;
    double h = length / 10;
    for (int i = 0; i < 10; i++)
        v[TEMPERATURE] += h * ((power - (v[TEMPERATURE] - v[AMBIENT]) * v[LOSS]) / v[CAPACITY]);
    v[HOT] = v[TEMPERATURE] > 60;
    v[STEPS] += 1;
    return OK;
}

static int set(Oven *oven, unsigned place, double value) {
    if (place >= COUNT || (oven->has_begun && (place == CAPACITY || place == LOSS)))
        return complain(oven, ERROR, "it cannot be set");
    oven->value[place] = value;
    return OK;
}

static int enter(Oven *oven) {
    if (oven->value[FAIL_HOW] == FAIL_START) return complain(oven, ERROR, "nothing to heat");
    oven->value[TEMPERATURE] = oven->value[AMBIENT];
    oven->has_begun = 1;
    return OK;
}

/* Tools look for all functions of the standard, whether they call them or not. */
#define NO(NAME) int NAME(void) { return ERROR; }

#ifndef FMI3

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static const Callbacks *callbacks;

static void log_two(void *environment, int status, const char *what) {
    callbacks->logger(environment, "oven", status, "logStatusError", "%s", what);
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const names[]) { return OK; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *functions, int visible,
                      int logging) {
    if (type != 1 || !guid || __builtin_strcmp(guid, GUID)) return NULL;
    Oven *oven = begin();
    callbacks = functions;
    oven->environment = functions->environment;
    oven->log = functions->logger ? log_two : NULL;
    return oven;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) { return OK; }
int fmi2EnterInitializationMode(void *c) { return enter(c); }
int fmi2ExitInitializationMode(void *c) { return OK; }
int fmi2Terminate(void *c) { return OK; }
int fmi2Reset(void *c) { return OK; }

#define ACCESS(NAME, TYPE)                                                                 \
    int fmi2Set##NAME(void *c, const unsigned vr[], size_t n, const TYPE value[]) {        \
        for (size_t i = 0; i < n; i++)                                                     \
            if (set(c, vr[i], value[i])) return ERROR;                                     \
        return OK;                                                                         \
    }                                                                                      \
    int fmi2Get##NAME(void *c, const unsigned vr[], size_t n, TYPE value[]) {              \
        for (size_t i = 0; i < n; i++) value[i] = (TYPE)((Oven *)c)->value[vr[i]];         \
        return OK;                                                                         \
    }
ACCESS(Real, double)
ACCESS(Integer, int)
ACCESS(Boolean, int)

int fmi2DoStep(void *c, double from, double length, int unused) { return step(c, from, length); }
int fmi2CancelStep(void *c) { return ERROR; }

NO(fmi2DeSerializeFMUstate) NO(fmi2FreeFMUstate) NO(fmi2GetBooleanStatus) NO(fmi2GetDirectionalDerivative)
NO(fmi2GetFMUstate) NO(fmi2GetIntegerStatus) NO(fmi2GetRealOutputDerivatives) NO(fmi2GetRealStatus) NO(fmi2GetStatus)
NO(fmi2GetString) NO(fmi2GetStringStatus) NO(fmi2SerializeFMUstate) NO(fmi2SerializedFMUstateSize) NO(fmi2SetFMUstate)
NO(fmi2SetRealInputDerivatives) NO(fmi2SetString)

#else

static void (*logger)(void *, int, const char *, const char *);
static void log_three(void *environment, int status, const char *what) { logger(environment, status, "logStatusError", what); }

const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const names[]) { return OK; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool events,
                                  bool early, const uint32_t required[], size_t n, void *environment,
                                  void (*log)(void *, int, const char *, const char *), void *update) {
    if (!token || __builtin_strcmp(token, GUID)) return NULL;
    Oven *oven = begin();
    logger = log;
    oven->environment = environment;
    oven->log = log ? log_three : NULL;
    return oven;
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    return enter(c);
}
int fmi3ExitInitializationMode(void *c) { return OK; }
int fmi3Terminate(void *c) { return OK; }
int fmi3Reset(void *c) { return OK; }

#define ACCESS(NAME, TYPE)                                                                              \
    int fmi3Set##NAME(void *c, const uint32_t vr[], size_t n, const TYPE value[], size_t values) {      \
        for (size_t i = 0; i < n; i++)                                                                  \
            if (set(c, vr[i], value[i])) return ERROR;                                                  \
        return OK;                                                                                      \
    }                                                                                                   \
    int fmi3Get##NAME(void *c, const uint32_t vr[], size_t n, TYPE value[], size_t values) {            \
        for (size_t i = 0; i < n; i++) value[i] = (TYPE)((Oven *)c)->value[vr[i]];                      \
        return OK;                                                                                      \
    }
ACCESS(Float32, float)
ACCESS(Float64, double)
ACCESS(Int8, int8_t)
ACCESS(UInt8, uint8_t)
ACCESS(Int16, int16_t)
ACCESS(UInt16, uint16_t)
ACCESS(Int32, int32_t)
ACCESS(UInt32, uint32_t)
ACCESS(Int64, int64_t)
ACCESS(UInt64, uint64_t)
ACCESS(Boolean, bool)

int fmi3DoStep(void *c, double from, double length, bool unused, bool *event, bool *end, bool *early, double *last) {
    Oven *oven = c;
    bool fails = from + length > oven->value[FAIL_AT];
    *event = false;
    *end = fails && oven->value[FAIL_HOW] == FAIL_END;
    *early = fails && oven->value[FAIL_HOW] == FAIL_EARLY;
    *last = *early ? from + length / 2 : from + length;
    return step(c, from, length);
}

NO(fmi3ActivateModelPartition) NO(fmi3CompletedIntegratorStep) NO(fmi3DeserializeFMUState) NO(fmi3EnterConfigurationMode)
NO(fmi3EnterContinuousTimeMode) NO(fmi3EnterEventMode) NO(fmi3EnterStepMode) NO(fmi3EvaluateDiscreteStates)
NO(fmi3ExitConfigurationMode) NO(fmi3FreeFMUState) NO(fmi3GetAdjointDerivative) NO(fmi3GetBinary) NO(fmi3GetClock)
NO(fmi3GetContinuousStateDerivatives) NO(fmi3GetContinuousStates) NO(fmi3GetDirectionalDerivative)
NO(fmi3GetEventIndicators) NO(fmi3GetFMUState) NO(fmi3GetIntervalDecimal) NO(fmi3GetIntervalFraction)
NO(fmi3GetNominalsOfContinuousStates) NO(fmi3GetNumberOfContinuousStates) NO(fmi3GetNumberOfEventIndicators)
NO(fmi3GetNumberOfVariableDependencies) NO(fmi3GetOutputDerivatives) NO(fmi3GetShiftDecimal) NO(fmi3GetShiftFraction)
NO(fmi3GetString) NO(fmi3GetVariableDependencies) NO(fmi3InstantiateModelExchange) NO(fmi3InstantiateScheduledExecution)
NO(fmi3SerializeFMUState) NO(fmi3SerializedFMUStateSize) NO(fmi3SetBinary) NO(fmi3SetClock) NO(fmi3SetContinuousStates)
NO(fmi3SetFMUState) NO(fmi3SetIntervalDecimal) NO(fmi3SetIntervalFraction) NO(fmi3SetShiftDecimal) NO(fmi3SetShiftFraction)
NO(fmi3SetString) NO(fmi3SetTime) NO(fmi3UpdateDiscreteStates)

#endif
