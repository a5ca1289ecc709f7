/* Tests that files of every release stay readable: those in tests/golden/VERSION must give the values that they were
 * written with. With a folder as argument, writes the files of this version there instead, which is done once per
 * release. */
#include <glob.h>
#include <sys/stat.h>

#include "samples.h"
#include "tlmw.h"
#include "track_folder.h"

enum { SAMPLES = 200, GRID = 50, LAST = 60, PLANES = 5 };

static void fill_period(toliman_period *period) {
    for (int i = 0; i < SAMPLES; i++)
        assert_ok(toliman_period_push(period, i + 0.125 * (i % 5), sin(0.3 * i), 1 + 0.5 * (i % 3)));
}

static toliman_period *made_period(void) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.001, 0.002, GRID, NULL, &period));
    fill_period(period);
    return period;
}

/* Patterns that compress well: a blob of a few kilobytes. */
static uint8_t *made_blob(size_t *size) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "\"shift_x\"");
    toliman_cae *cae = make_cae(sim, 1, 0, NULL);
    uint8_t *blob = saved(cae, size);
    toliman_cae_destroy(cae);
    toliman_sim_destroy(sim);
    float *weights = malloc(kParameters * sizeof *weights), *planes = malloc(PLANES * kPixels * sizeof *planes);
    for (int i = 0; i < kParameters; i++)
        weights[i] = (float)(i * 7 % 13 - 6) / 64;
    for (int i = 0; i < PLANES * kPixels; i++)
        planes[i] = i / kPixels == 1 ? 0 : i / kPixels < 3 ? 100 : (float)(i % 2) - 0.5f;
    uint8_t *made = with_payloads(blob, weights, planes, PLANES, size);
    free(weights), free(planes), free(blob);
    assert_ok(toliman_cae_load(made, *size, NULL, &cae));
    free(made);
    const int bf16 = TOLIMAN_CAE_ENCODING_BF16 - TOLIMAN_CAE_ENCODING_FLOAT32;
    made = saved_as(cae, bf16, bf16, size);
    toliman_cae_destroy(cae);
    return made;
}

static double latent_of(const toliman_cae *cae) {
    double *frame = new_image(kPixels), latent = 0;
    for (int i = 0; i < kPixels; i++)
        frame[i] = 100 + i % 31 - i / kSide % 17;
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    free(frame);
    return latent;
}

static toliman_track_options made_options(const char *in) {
    toliman_track_options options = small_options(in);
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    return options;
}

static void push_frames(toliman_track *track) {
    small_frame frame;
    push_range(track, 1, LAST / 2);
    make_frame(&frame, 10);
    frame.pixels[0]++; /* quarantined */
    push_one(track, &frame.frame);
    assert_ok(toliman_track_save(track));
    push_range(track, LAST / 2 + 1, LAST);
}

static void write_files(const char *version) {
    char path[600];
    toliman_period *period = made_period();
    snprintf(path, sizeof path, "%s/state.tlmp", version);
    assert_ok(toliman_period_save_file(period, path));
    toliman_period_destroy(period);

    size_t size;
    toliman_cae *cae = NULL;
    uint8_t *blob = made_blob(&size);
    assert_ok(toliman_cae_load(blob, size, NULL, &cae));
    snprintf(path, sizeof path, "%s/weights.tlmw", version);
    assert_ok(
        toliman_cae_save_file(cae,
                              &(toliman_cae_save_options){sizeof(toliman_cae_save_options), TOLIMAN_CAE_ENCODING_BF16,
                                                          TOLIMAN_CAE_ENCODING_BF16, 0},
                              path));
    snprintf(path, sizeof path, "%s/latent.txt", version);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "%.17g\n", latent_of(cae));
    fclose(file);
    toliman_cae_destroy(cae);
    free(blob);

    snprintf(path, sizeof path, "%s/mission", version);
    const toliman_track_options options = made_options(path);
    toliman_track *track = make_track(&options);
    push_frames(track);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    snprintf(path, sizeof path, "%s/mission/lock", version);
    unlink(path);
}

static void read_state(const char *version) {
    char path[600];
    double power[GRID], expected[GRID];
    toliman_period *period = NULL, *made = made_period();
    snprintf(path, sizeof path, "%s/state.tlmp", version);
    assert_ok(toliman_period_load_file(path, NULL, &period));
    assert_int_equal(count_of(period), SAMPLES);
    assert_ok(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, GRID, power));
    assert_ok(toliman_period_query_power(made, TOLIMAN_PERIOD_POWER_STANDARD, 0, GRID, expected));
    for (int i = 0; i < GRID; i++)
        assert_close(power[i], expected[i], 1e-12, 1e-14);
    assert_ok(toliman_period_push(period, 500, 1, 1)); /* and it continues */
    toliman_period_destroy(period);
    toliman_period_destroy(made);
}

static void read_weights(const char *version) {
    char path[600];
    double latent = 0;
    toliman_cae *cae = NULL;
    snprintf(path, sizeof path, "%s/weights.tlmw", version);
    assert_ok(toliman_cae_load_file(path, NULL, &cae));
    snprintf(path, sizeof path, "%s/latent.txt", version);
    FILE *file = fopen(path, "r");
    assert_int_equal(fscanf(file, "%lf", &latent), 1);
    fclose(file);
    assert_close(latent_of(cae), latent, 1e-5, 0);
    toliman_cae_destroy(cae);
}

static int has(const char *version, const char *name) {
    char path[600];
    snprintf(path, sizeof path, "%s/%s", version, name);
    return access(path, F_OK) == 0;
}

/* A copy is opened and continued; the files of the release are not modified. */
static void read_mission(const char *version) {
    char above[256], path[300], command[1200];
    make_folder(above, sizeof above);
    snprintf(path, sizeof path, "%s/mission", above);
    snprintf(command, sizeof command, "cp -r '%s/mission' '%s'", version, above);
    assert_int_equal(system(command), 0);
    const toliman_track_options options = made_options(path), fresh = made_options(NULL);
    toliman_track *track = make_track(&options), *expected = make_track(&fresh);
    for (int64_t id = 1; id <= LAST; id++)
        if (id != 10)
            push_number(expected, id);
    assert_same_periods(period_of(track), period_of(expected));
    toliman_track_options kept = TOLIMAN_TRACK_OPTIONS_INIT; /* times are the middle of an exposure of unknown length */
    assert_ok(toliman_track_get_options(track, &kept));
    assert_true(kept.frames.stamp == TOLIMAN_FRAME_STAMP_MIDDLE && kept.frames.exposure_s == 0);
    assert_int_equal(info_of(track).quarantined, 1);
    assert_int_equal(push_number(track, LAST), TOLIMAN_TRACK_VERDICT_DUPLICATE);
    assert_int_equal(push_number(track, LAST + 1), TOLIMAN_TRACK_VERDICT_ACCEPTED);
    toliman_track_destroy(track);
    toliman_track_destroy(expected);
    remove_folder(path);
    remove_folder(above);
}

/* promise: other-versions-are-refused */
TEST(files_of_every_release) {
    glob_t releases;
    int missions = 0, states = 0; /* the ledger has another format since 0.2 */
    assert_int_equal(glob("tests/golden/[0-9]*", 0, NULL, &releases), 0);
    for (size_t i = 0; i < releases.gl_pathc; i++) {
        print_message("%s\n", releases.gl_pathv[i]);
        if (has(releases.gl_pathv[i], "state.tlmp"))
            read_state(releases.gl_pathv[i]);
        if (has(releases.gl_pathv[i], "weights.tlmw"))
            read_weights(releases.gl_pathv[i]);
        if (has(releases.gl_pathv[i], "mission"))
            read_mission(releases.gl_pathv[i]);
        missions += has(releases.gl_pathv[i], "mission");
        states += has(releases.gl_pathv[i], "state.tlmp");
    }
    globfree(&releases);
    assert_true(missions > 0 && states > 0);
}

int main(int count, char **arguments) {
    if (count > 1) {
        write_files(arguments[1]);
        return 0;
    }
    return RUN_ALL(NULL, NULL);
}
