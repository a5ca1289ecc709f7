/* Tests that objects with random contents, saved, loaded and saved again, give the same bytes. TOLIMAN_OBJECTS sets the
 * number of objects. */
#include "samples.h"
#include "tlmw.h"
#include "track_folder.h"

enum { MOST_GRID = 24, MOST_SAMPLES = 40, PLANES = 4 };

static uint64_t objects = 5000, draws = 1;

/* A magnitude between 1e-`digits` and 1e`digits`, of either sign. */
static double any_number(int digits) {
    const double size = pow(10, (double)draw(&draws, 2000 * (uint64_t)digits) / 1000 - digits);
    return draw(&draws, 2) ? size : -size;
}

static toliman_period *any_period(void) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.flags = (uint32_t)draw(&draws, 4); /* FIXED_MEAN, WIDE */
    options.unit_ns = draw(&draws, 2) ? options.unit_ns : 1 + (double)draw(&draws, 1000000000);
    options.time_offset_ns = (int64_t)draw(&draws, (uint64_t)1 << 60);
    options.time_offset = any_number(6) * (double)draw(&draws, 2);
    options.value_offset = any_number(3) * (double)draw(&draws, 2);
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.01 * (double)draw(&draws, 3), fabs(any_number(3)),
                                    2 + (int64_t)draw(&draws, MOST_GRID), &options, &period));
    for (uint64_t left = draw(&draws, MOST_SAMPLES); left > 0; left--) { /* some are refused */
        const int32_t status = toliman_period_push(period, any_number(6), any_number(3), 1 + 0.001 * (double)left);
        assert_true(status == TOLIMAN_OK || status == TOLIMAN_E_RANGE);
    }
    return period;
}

/* promise: loading-restores-what-was-saved */
TEST(periodograms) {
    static unsigned char bytes[STATE_CAPACITY], again[STATE_CAPACITY];
    int64_t samples = 0;
    for (uint64_t object = 0; object < objects; object++) {
        toliman_period *period = any_period(), *loaded = NULL;
        size_t size, size_again;
        assert_ok(toliman_period_save(period, bytes, sizeof bytes, &size));
        assert_ok(toliman_period_load(bytes, size, NULL, &loaded));
        assert_ok(toliman_period_save(loaded, again, sizeof again, &size_again));
        assert_int_equal(size, size_again);
        assert_memory_equal(bytes, again, size);
        samples += count_of(period);
        toliman_period_destroy(period), toliman_period_destroy(loaded);
    }
    assert_true(samples > (int64_t)objects);
    print_message("%llu periodograms of %lld samples\n", (unsigned long long)objects, (long long)samples);
}

static void fill(float *numbers, size_t count) {
    const uint64_t seed = draws++;
    for (size_t i = 0; i < count; i++) {
        const uint64_t bits = mixed(seed * count + i);
        numbers[i] = ldexpf((float)(bits % 20001) / 10000 - 1, (int)(bits >> 32) % 60 - 30);
    }
}

/* promises: loading-restores-what-was-saved, networks-save-same-bytes */
TEST(networks) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_cae *cae = make_cae(sim, 1, 0, NULL);
    toliman_sim_destroy(sim);
    size_t size, size_first, size_second;
    uint8_t *blob = saved(cae, &size);
    toliman_cae_destroy(cae);
    float *weights = malloc(kParameters * sizeof *weights), *planes = malloc(PLANES * kPixels * sizeof *planes);
    const uint64_t count = 1 + objects / 10000;
    for (uint64_t object = 0; object < count; object++) {
        fill(weights, kParameters);
        fill(planes, PLANES * kPixels);
        for (size_t i = 2 * kPixels; i < 3 * kPixels; i++)
            planes[i] = fabsf(planes[i]) + 1; /* the variance */
        uint8_t *made = with_payloads(blob, weights, planes, PLANES, &size);
        assert_ok(toliman_cae_load(made, size, NULL, &cae));
        const int32_t encoding = (int32_t)draw(&draws, 2), of_planes = (int32_t)draw(&draws, 2);
        uint8_t *first = saved_as(cae, encoding, of_planes, &size_first);
        toliman_cae_destroy(cae);
        assert_ok(toliman_cae_load(first, size_first, NULL, &cae));
        uint8_t *second = saved_as(cae, encoding, of_planes, &size_second);
        toliman_cae_destroy(cae);
        assert_int_equal(size_first, size_second);
        assert_memory_equal(first, second, size_first);
        free(made), free(first), free(second);
    }
    free(weights), free(planes), free(blob);
    print_message("%llu networks\n", (unsigned long long)count);
}

static size_t contents(const char *path, unsigned char *bytes, size_t capacity) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, capacity, file);
    fclose(file);
    return size;
}

/* A folder that is opened and saved: no byte of its three files changes. */
/* promise: loading-restores-what-was-saved */
TEST_IN_FOLDER(folders) {
    enum { CAPACITY = 1 << 16 };
    static unsigned char before[CAPACITY], after[CAPACITY];
    const char *const files[] = {ledger, checkpoint, setup};
    const uint64_t count = objects / 1000;
    for (uint64_t object = 0; object < count; object++) {
        toliman_track_options options = small_options(folder);
        options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
        options.grid.nf = 1 + (int64_t)draw(&draws, FREQUENCIES);
        toliman_track *track = make_track(&options);
        for (uint64_t left = draw(&draws, 60); left > 0; left--) {
            small_frame frame;
            make_frame(&frame, 1 + (int64_t)draw(&draws, 100));
            if (draw(&draws, 10) == 0)
                frame.pixels[draw(&draws, PIXELS)] ^= 1;
            push_one(track, &frame.frame);
        }
        assert_ok(toliman_track_save(track));
        toliman_track_destroy(track);
        for (int i = 0; i < 3; i++) {
            const size_t size = contents(files[i], before, CAPACITY);
            track = make_track(&options);
            assert_ok(toliman_track_save(track));
            toliman_track_destroy(track);
            assert_int_equal(contents(files[i], after, CAPACITY), size);
            assert_memory_equal(before, after, size);
        }
        remove_folder(folder);
    }
    assert_int_equal(mkdir(folder, 0777), 0);
    print_message("%llu folders\n", (unsigned long long)count);
}

int main(void) {
    const char *given = getenv("TOLIMAN_OBJECTS");
    objects = given != NULL ? (uint64_t)atoll(given) : objects;
    return RUN_ALL(NULL, NULL);
}
