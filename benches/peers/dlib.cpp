// Measures dlib's recursive least squares, double precision, on vectors of fixed size.
#include <dlib/revision.h>
#include <dlib/svm/rls.h>

#include "timing.h"

int main() {
    static double times[REPETITIONS], target[SAMPLES];
    static dlib::matrix<double, N, 1> phi[SAMPLES];
    for (int k = 0; k < SAMPLES; k++) {
        for (int i = 0; i < N; i++) phi[k](i) = uniform();
        target[k] = uniform();
    }
    dlib::rls rls(0.999, 100.0);
    for (int r = 0; r < REPETITIONS; r++) {
        double start = now();
        for (int k = 0; k < SAMPLES; k++) rls.train(phi[k], target[k]);
        times[r] = now() - start;
    }
    char version[32];
    snprintf(version, sizeof version, "%d.%d", DLIB_MAJOR_VERSION, DLIB_MINOR_VERSION);
    report("dlib", "f64", version, times);
    return rls.get_w()(0) == rls.get_w()(0) ? 0 : 1;
}
