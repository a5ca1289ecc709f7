/* libtoliman, core: the functions that lead from a scene, or the frames of a camera, to a period. They are the last
 * to change.
 *
 * Data flow (toliman_...)
 *
 *   scene -> sim_create_file -> toliman_sim -> sim_frame -> images                    simulated frames
 *                                   |
 *                                   +-> cae_create -> toliman_cae -> cae_train        the network of a scene
 *                                                       |   save_file, load_file      its weights
 *                                                       +-> cae_encode -> latent      one number for each frame
 *
 *   times -> period_suggest -> period_create -> toliman_period <- period_push         time, number, sigma
 *                                                  +-> period_query_peak              the period
 *
 *   toliman_cae -> track_create -> toliman_track <- track_push                        frames of a downlink
 *                                     +-> track_get_period -> toliman_period
 *
 *   any status but TOLIMAN_OK -> last_error                                           what was wrong, in English
 *
 * Frames of stars that move are fitted (fit.h), series searched for planets (measure.h, planet.h). */
#ifndef TOLIMAN_CORE_H
#define TOLIMAN_CORE_H

#include <toliman/base.h>
#include <toliman/cae.h>
#include <toliman/period.h>
#include <toliman/sim.h>
#include <toliman/track.h>

#endif
