/* What the table `scenarios` names: values of arguments, and the objects, files and checks that need code of their
 * own. */
#ifndef TOLIMAN_TESTS_OBJECTS_H
#define TOLIMAN_TESTS_OBJECTS_H

#include <math.h>
#include <string.h>

#include "assert_close.h"
#include "images.h"
#include "scenario.h"

enum { LARGE = 256, SMALL = 24, FRAMES = 8, PUPIL = 32, SAVED_CAPACITY = 1 << 20 };
enum { GRID = 90, SAMPLES = 60, ARCHIVE = 3000, POINTS = 20, PLANET_POINTS = 40, PAIR_PIXELS = 16, DESCENT = 3 };
enum { HELD = 30, LAST_FRAME = 44, COMING = LAST_FRAME - HELD, COMING_REDUCED = 4 };
#define F0 0.01
#define DF 0.005
#define SOME_FRAMES "sim.h: after an error, images may hold some of the frames"
#define STEPS_KEPT "cae.h: complete steps or epochs are kept, so that training can be resumed"
#define TRAINED "bank.h: networks that were trained remain, so that a later call continues"
#define FIRST_DONE "track.h: on an error the first *done frames were accepted"
#define PARTLY_MERGED "track.h: some records may have been merged, and count again when merged again"

/* scenes.c */
enum { BINARY, IMPOSSIBLE, EVERYTHING, ORBIT, CLEAR, SCENES };
const char *scene_text(int scene);
const toliman_sim *large_sim(void);
const double *large_frames(void); /* [FRAMES][LARGE][LARGE] of it */
const double *small_frames(void); /* [FRAMES][SMALL][SMALL] */
const toliman_cae_train_options *unsupervised(uint32_t epochs, uint32_t threads);
int32_t keep_going(const char *stage, double fraction, void *unused);
int32_t stop_step(const toliman_calibration *so_far, const toliman_calibration_step *step, void *unused);
void ignore_log(int32_t level, const char *text, void *unused);
void *create_sim_json_threads(void);
void *make_large_fit(void);
void *make_coadd(void); /* with one frame */
const toliman_frame *short_frame(void);
const void *coadd_bytes(void);
size_t coadd_size(void);

/* series.c */
extern const int64_t kSkyTimes[3], kSkyIntervals[4];
extern const toliman_leap_second kLeapSeconds[2];
const double *times(void); /* [ARCHIVE], days */
const double *values(void);
const double *values_above(void);
const toliman_measure_data *separations(size_t n, int days);
const toliman_frame *ramp(void);
void *make_shifted(void);
void *make_wide_shifted(void);
void *make_planet_series(void);
void *make_sky_series(void);
void *make_sky_dates(void);
void *make_sky_months(void);
extern const object_kind period_kind;

/* trackers.c */
enum { ORBIT_SKY, OTHER_SKY, SKIES };
const toliman_track_options *mission(uint32_t flags, double f0);
const toliman_track_options *in_memory(void);
const toliman_track_options *with_network(void);
const toliman_track_options *with_template(void);
const toliman_track_options *with_fit(uint32_t threads);
const toliman_track_options *reduced(int sky, uint32_t flags);
const toliman_frame *coming(void);
const toliman_frame *coming_images(const double *images, size_t side);
const toliman_frame *coming_reduced(void);
void *create_linear(void);
void *create_fit(void);
void *create_cae(void);
void *create_bank(void);

#endif
