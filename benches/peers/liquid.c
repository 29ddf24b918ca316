/* Measures the recursive least squares equaliser of liquid-dsp, single precision. */
#include <liquid/liquid.h>

#include "timing.h"

int main(void) {
    static float phi[SAMPLES], target[SAMPLES];
    static double times[REPETITIONS];
    for (int k = 0; k < SAMPLES; k++) {
        phi[k] = (float)uniform();
        target[k] = (float)uniform();
    }
    eqrls_rrrf rls = eqrls_rrrf_create(NULL, N);
    eqrls_rrrf_set_bw(rls, 0.999f);
    for (int r = 0; r < REPETITIONS; r++) {
        double start = now();
        for (int k = 0; k < SAMPLES; k++) {
            float estimate;
            eqrls_rrrf_push(rls, phi[k]);
            eqrls_rrrf_execute(rls, &estimate);
            eqrls_rrrf_step(rls, target[k], estimate);
        }
        times[r] = now() - start;
    }
    report("liquid-dsp", "f32", liquid_libversion(), times);
    eqrls_rrrf_destroy(rls);
    return 0;
}
