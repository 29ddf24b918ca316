/* The mass on a spring of mass.c as an FMI 3.0 co-simulation unit, for tests, with the same references. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef void *Instance;
typedef const char *String;
typedef void (*Log)(void *, int, String, String);
typedef struct {
    double v[9];
    int is_initialised;
    void *environment;
    Log log;
} Mass;

static void fresh(Mass *m) {
    static const double start[9] = {0, 0, 0.1, 0, 1.5, 0.8, 6.0, 0, 0};
    memcpy(m->v, start, sizeof start);
    m->is_initialised = 0;
}

const char *fmi3GetVersion(void) { return VERSION; }

Instance fmi3InstantiateCoSimulation(String name, String token, String resources, bool visible, bool logging, bool events,
                                     bool early, const uint32_t *intermediate, size_t n, void *environment, Log log,
                                     void *update) {
    Mass *m;
    size_t length = strlen(resources);
    if (token[0] != '{' || events || early || n != 0 || update != NULL || resources[length - 1] != '/') {
        log(environment, 3, "error", "not what was asked for");
        return NULL;
    }
    m = calloc(1, sizeof(Mass));
    if (!m) return NULL;
    m->environment = environment;
    m->log = log;
    fresh(m);
    return m;
}

void fmi3FreeInstance(Instance i) { free(i); }

int fmi3EnterInitializationMode(Instance i, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    return has_tolerance || has_stop ? 3 : 0;
}
int fmi3ExitInitializationMode(Instance i) {
    ((Mass *)i)->is_initialised = 1;
    return 0;
}
int fmi3Reset(Instance i) {
    fresh(i);
    return 0;
}

int fmi3SetFloat64(Instance i, const uint32_t *r, size_t n, const double *x, size_t values) {
    Mass *m = i;
    if (values != n) return 3;
    for (size_t k = 0; k < n; k++) {
        /* Parameters and states are set before the initialisation. */
        if (m->is_initialised && 2 <= r[k]) return 3;
        m->v[r[k]] = x[k];
    }
    return 0;
}

int fmi3GetFloat64(Instance i, const uint32_t *r, size_t n, double *x, size_t values) {
    if (values != n) return 3;
    for (size_t k = 0; k < n; k++) x[k] = ((Mass *)i)->v[r[k]];
    return 0;
}

int fmi3DoStep(Instance i, double t, double h, bool no_return, bool *event, bool *over, bool *early, double *reached) {
    Mass *m = i;
    double *v = m->v;
    *event = *early = false;
    *over = FAULT == 1 && v[7] > 0 && v[7] < t;
    *reached = t + h;
    if (v[7] > 0 && v[7] < t && FAULT != 1) {
        m->log(m->environment, FAULT, "error", "the spring has broken");
        return FAULT;
    }
    for (int k = 0; k < 4; k++) {
        double a = (v[0] + v[1] - v[5] * v[3] - v[6] * v[2]) / v[4];
        v[3] += 0.25 * h * a;
        v[2] += 0.25 * h * v[3];
    }
    return 0;
}
