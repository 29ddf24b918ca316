/* A cart on a rail as a simulator of `fdiag gap`: docs/process-protocol.md in C, little endian machines.
   cc -O2 -o cart cart.c -lm */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static const double TS = 0.01;
static const char *HELLO =
    "{\"version\": 1, \"name\": \"cart\", \"sample_time\": 0.01,"
    " \"inputs\": [{\"name\": \"force\", \"unit\": \"N\"}],"
    " \"outputs\": [{\"name\": \"speed\", \"unit\": \"m/s\", \"noise\": 0.004}],"
    " \"parameters\": [{\"name\": \"m\", \"unit\": \"kg\", \"value\": 1.2, \"tolerance\": 0.03},"
    "                  {\"name\": \"d\", \"unit\": \"N s/m\", \"value\": 1.5, \"tolerance\": 0.1}],"
    " \"states\": [{\"name\": \"v\", \"unit\": \"m/s\", \"initial\": 0}],"
    " \"ports\": [{\"name\": \"rail\", \"unit\": \"N\", \"velocity\": \"speed\"}],"
    " \"powers\": {\"rollout\": true, \"measure\": true, \"states\": true}}";

static double m, d, v;

static void step(double force, double push) { /* exact for inputs that are held */
    double aim = (force + push) / d;
    v = aim + (v - aim) * exp(-d / m * TS);
}

int main(void) {
    uint32_t head[3];
    for (int c = 0; c != '\n' && c != EOF;) c = getchar(); /* what the model file says */
    printf("%s\n", HELLO);
    fflush(stdout);
    while (fread(head, sizeof head, 1, stdin) == 1) {
        uint32_t op = head[0], count = head[2], n = 0;
        double *a = malloc(8 * (count + 1)), *y = malloc(8 * (count + 2));
        if (!a || !y || fread(a, 8, count, stdin) != count || op == 5) return 0;
        switch (op) {
        case 1: m = a[1], d = a[2], v = a[3]; break;                      /* reset */
        case 2: y[n++] = v; step(a[0], a[1]); y[n++] = v; break;          /* step: outputs, states */
        case 3:                                                           /* rollout */
            m = a[2], d = a[3], v = a[4];
            for (uint32_t k = 5; k < count; k += 2) y[n++] = v, step(a[k], a[k + 1]);
            y[n++] = v;
            break;
        case 4: y[n++] = v; break;                                        /* measure */
        }
        head[1] = 1, head[2] = n;
        fwrite(head, sizeof head, 1, stdout);
        fwrite(y, 8, n, stdout);
        fflush(stdout);
        free(a), free(y);
    }
    return 0;
}
