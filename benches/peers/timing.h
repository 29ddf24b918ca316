/* Repeats some work and prints the fastest and the median time per update as one JSON object. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { N = 5, SAMPLES = 256, REPETITIONS = 8000 };

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double uniform(void) { return 2.0 * rand() / RAND_MAX - 1.0; }

static void report(const char *name, const char *scalar, const char *version, double *times) {
    qsort(times, REPETITIONS, sizeof *times, ascending);
    printf("{\"name\": \"%s\", \"what\": \"rls update, n = 5\", \"scalar\": \"%s\", "
           "\"fastest\": %g, \"median\": %g, \"version\": \"%s\"}\n",
           name, scalar, times[0] / SAMPLES, times[REPETITIONS / 2] / SAMPLES, version);
}
