/* A mass on a spring as an FMI 2.0 co-simulation unit, for tests. References: 0 force, 1 push, 2 place, 3 speed,
   4 m, 5 d, 6 k, 7 fault, 8 energy (local). */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *Component;
typedef const char *String;
typedef void (*Logger)(void *, String, int, String, String, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
typedef struct {
    double v[9];
    int is_initialised;
    const Callbacks *callbacks;
} Mass;

static void fresh(Mass *m) {
    static const double start[9] = {0, 0, 0.1, 0, 1.5, 0.8, 6.0, 0, 0};
    for (int i = 0; i < 9; i++) m->v[i] = start[i];
    m->is_initialised = 0;
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return VERSION; }

Component fmi2Instantiate(String name, int type, String guid, String resources, const Callbacks *c, int visible, int log) {
    Mass *m;
    if (type != 1 || guid[0] != '{') {
        c->logger(c->environment, name, 3, "error", "another guid: %s", guid);
        return NULL;
    }
    m = c->allocate(1, sizeof(Mass));
    if (!m) return NULL;
    m->callbacks = c;
    fresh(m);
    return m;
}

void fmi2FreeInstance(Component c) {
    Mass *m = c;
    if (m) m->callbacks->release(m);
}

int fmi2SetupExperiment(Component c, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    return 0;
}
int fmi2EnterInitializationMode(Component c) { return 0; }
int fmi2ExitInitializationMode(Component c) {
    ((Mass *)c)->is_initialised = 1;
    return 0;
}
int fmi2Terminate(Component c) { return 0; }
int fmi2Reset(Component c) {
#ifdef DIE_IN_RESET
    abort();
#endif
#ifdef NO_RESET
    return 3;
#endif
#ifdef EMPTY_RESET
    ((Mass *)c)->is_initialised = 0;
    return 0;
#endif
    fresh(c);
    return 0;
}

int fmi2SetReal(Component c, const unsigned *r, size_t n, const double *x) {
    Mass *m = c;
    for (size_t i = 0; i < n; i++) {
        /* Parameters and states are set before the initialisation. */
        if (m->is_initialised && 2 <= r[i]) return 3;
        m->v[r[i]] = x[i];
    }
    return 0;
}

int fmi2GetReal(Component c, const unsigned *r, size_t n, double *x) {
    for (size_t i = 0; i < n; i++) x[i] = ((Mass *)c)->v[r[i]];
    return 0;
}

int fmi2DoStep(Component c, double t, double h, int no_return) {
    Mass *m = c;
    double *v = m->v;
#ifdef TALK
    puts("a step of the mass");
    fflush(stdout);
#endif
    if (v[7] > 0 && v[7] < t) {
#ifdef DIE
        DIE;
#endif
        m->callbacks->logger(m->callbacks->environment, "mass", FAULT, "error", "the spring has %s", "broken");
        return FAULT;
    }
    for (int i = 0; i < 4; i++) {
        double a = (v[0] + v[1] - v[5] * v[3] - v[6] * v[2]) / v[4];
        v[3] += 0.25 * h * a;
        v[2] += 0.25 * h * v[3];
    }
    return 0;
}
