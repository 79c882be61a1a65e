/* A loop around a reduced tail at 1 kHz: a proportional-integral-derivative controller of one output, as examples/tip_control.rs, in C.
 *
 * cc -O2 tip_control.c -o tip_control -L target/release -ltwin_c -lm -Wl,-rpath,target/release
 * ./tip_control ../tail.safetensors m6_y 0.005
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include "twin.h"

#define RATE 1000.0

static void fail(void) {
    fprintf(stderr, "%s\n", twin_error());
    exit(1);
}

/* Displacement (m) of the output under a lasting pressure (Pa) in the first chamber. */
static double reach(const twin *tail, size_t output, double pressure) {
    double pressures[2] = {0.0, 0.0};
    twin_state *state = twin_start(tail);
    for (int n = 1; n <= 200; n++) {
        pressures[0] = pressure * n / 200.0;
        if (twin_step(tail, state, pressures, 0.005)) fail();
    }
    double displacement = twin_output(tail, state, output);
    twin_state_free(state);
    return displacement;
}

int main(int count, char **arguments) {
    if (count != 4) {
        fprintf(stderr, "tip_control FILE OUTPUT TARGET_M\n");
        return 2;
    }
    twin *tail = twin_open(arguments[1]);
    if (!tail) fail();
    long output = twin_output_number(tail, arguments[2]);
    double range[2], goal = atof(arguments[3]);
    if (twin_chambers(tail) != 2) {
        fprintf(stderr, "the loop is for a tail of two chambers\n");
        return 2;
    }
    if (output < 0 || twin_chamber_range(tail, 0, range)) fail();
    double highest = fmin(range[1], 2e4), gain = highest / reach(tail, (size_t)output, highest), integral = 0.0, last = 0.0;
    twin_state *state = twin_start(tail);
    if (!state) fail();
    for (int n = 0; n < 3 * (int)RATE; n++) {
        double tip = twin_output(tail, state, (size_t)output), error = goal - tip;
        double command = gain * (0.5 * error + 5.0 * (integral + error / RATE) - 0.04 * (tip - last) * RATE);
        double pressure = fmax(-highest, fmin(highest, command)), pressures[2] = {fmax(pressure, 0.0), fmax(-pressure, 0.0)};
        if (pressure == command) integral += error / RATE; /* it stands still while the valves are at their limit */
        last = tip;
        if (twin_step(tail, state, pressures, 1.0 / RATE)) fail();
    }
    printf("%.9f %.9f\n", twin_time(state), twin_output(tail, state, (size_t)output));
    twin_state_free(state);
    twin_free(tail);
    return 0;
}
