/* Positions of a scene's stars as an array. */
#ifndef TOLIMAN_TESTS_OFFSETS_H
#define TOLIMAN_TESTS_OFFSETS_H

#include <toliman/sim.h>

#include "assert_close.h"

/* {Ax, Ay, Bx, By} */
static inline void get_offsets(const toliman_sim *sim, double offsets_px[4]) {
    toliman_sim_offsets at = TOLIMAN_SIM_OFFSETS_INIT;
    assert_ok(toliman_sim_get_offsets(sim, &at));
    const double all[4] = {at.a_x_px, at.a_y_px, at.b_x_px, at.b_y_px};
    for (int i = 0; i < 4; i++)
        offsets_px[i] = all[i];
}

#endif
