/* A reduced tail that steps in real time, for C and everything that calls C.
 *
 * `cargo build --release` in this folder makes target/release/libtwin_c.so (.dylib, twin_c.dll) and libtwin_c.a.
 * SI units throughout. A function that can fail returns 0 where it succeeded, or NULL where it did not; twin_error says why.
 * A tail may be shared by threads, a state belongs to one at a time.
 */
#ifndef TWIN_H
#define TWIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct twin twin;
typedef struct twin_state twin_state;

/* The tail in a file of `study export twin`; freed by twin_free. */
twin *twin_open(const char *path);
void twin_free(twin *tail);

/* Why the last call of this thread failed: what, why and what to do, until its next call. */
const char *twin_error(void);

/* Counts, and the names in their order; a name lives as long as the tail. NULL where there is no such number. */
size_t twin_chambers(const twin *tail);
size_t twin_outputs(const twin *tail);
const char *twin_chamber_name(const twin *tail, size_t chamber);
const char *twin_output_name(const twin *tail, size_t output);
/* The number of an output, or -1. */
long twin_output_number(const twin *tail, const char *name);
/* Lowest and highest pressure of a chamber, Pa. */
int twin_chamber_range(const twin *tail, size_t chamber, double range[2]);

/* The tail at rest; freed by twin_state_free. */
twin_state *twin_start(const twin *tail);
void twin_state_free(twin_state *state);

/* Steps by `duration` (s), at whose end each of the twin_chambers has its pressure (Pa). A step that fails leaves the state as it was. */
int twin_step(const twin *tail, twin_state *state, const double *pressures, double duration);

double twin_time(const twin_state *state);
/* Displacement of an output, m; not a number where there is no such output. */
double twin_output(const twin *tail, const twin_state *state, size_t output);
/* Volume of a chamber, m^3; not a number where there is no such chamber. */
double twin_volume(const twin *tail, const twin_state *state, size_t chamber);
/* The largest coordinate over that of the shapes that the tail was reduced from: above 1 it is larger than anything that was seen. */
double twin_excursion(const twin *tail, const twin_state *state);

/* Writes the state to `bytes`, where there is room for `length`, and sets `length` to its own; with bytes = NULL that alone. */
int twin_save(const twin *tail, const twin_state *state, uint8_t *bytes, size_t *length);
/* A saved state; freed by twin_state_free. */
twin_state *twin_restore(const twin *tail, const uint8_t *bytes, size_t length);

#ifdef __cplusplus
}
#endif
#endif
