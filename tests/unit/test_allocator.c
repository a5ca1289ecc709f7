/* Tests the caller's allocator: every large array of an object comes from it and is freed with its size. If it fails,
 * no object is created and nothing leaks. */
#include <malloc.h>
#include <sys/mman.h>

#include "cae_scene.h"
#include "images.h"
#include "test_folder.h"

#include <toliman/bank.h>
#include <toliman/calibrate.h>
#include <toliman/components.h>
#include <toliman/linear.h>
#include <toliman/track.h>

enum { TRACKED = 1 << 17, FREQUENCIES = 20000, COLLECTED = 20 };

/* Counts allocations; allocation number fails_at fails. */
typedef struct arena {
    size_t calls, held, all, fails_at;
} arena;

static void *arena_allocate(size_t size, size_t alignment, void *user_data) {
    arena *from = user_data;
    assert_true(alignment == 64 && size % 64 == 0 && size > 0);
    if (from->calls++ == from->fails_at)
        return NULL;
    from->held += size;
    from->all += size;
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(memory != MAP_FAILED);
    return memory;
}

static void arena_release(void *memory, size_t size, void *user_data) {
    arena *to = user_data;
    assert_true(memory != NULL && to->held >= size);
    to->held -= size;
    munmap(memory, size);
}

static toliman_allocator allocator_of(arena *memory) {
    return (toliman_allocator){sizeof(toliman_allocator), 0, arena_allocate, arena_release, memory};
}

/* Inputs from which the objects are created. */
static toliman_sim *scene;
static toliman_linear *estimator;
static toliman_fit *fit;
static char weights_file[300], state_file[300], bank_file[300], folder[256];
static unsigned char *weights, *state, *bank_bytes;
static double two_frames[2 * kPixels];
static size_t weights_size, state_size, bank_size;

/* Each creates an object with an allocator. */
static toliman_status sim_of(uint32_t threads, const toliman_allocator *allocator, void **out) {
    char json[2048];
    const size_t size = write_scene(json, sizeof json, kSide, kSide, 0, "");
    const toliman_sim_options options = {.struct_size = sizeof options, .threads = threads, .allocator = allocator};
    return toliman_sim_create_json(json, size, NULL, &options, (toliman_sim **)out);
}

static toliman_status sim_in(const toliman_allocator *allocator, void **out) {
    return sim_of(1, allocator, out);
}

static toliman_status sim_of_threads_in(const toliman_allocator *allocator, void **out) {
    return sim_of(4, allocator, out);
}

static toliman_status cae_in(const toliman_allocator *allocator, void **out) {
    const toliman_cae_options options = {.struct_size = sizeof options, .allocator = allocator};
    return toliman_cae_create(scene, 3, &options, (toliman_cae **)out);
}

static toliman_status linear_in(const toliman_allocator *allocator, void **out) {
    const toliman_linear_options options = {.struct_size = sizeof options, .allocator = allocator};
    return toliman_linear_create(scene, &options, (toliman_linear **)out);
}

static toliman_status fit_in(const toliman_allocator *allocator, void **out) {
    const toliman_fit_options options = {.struct_size = sizeof options, .allocator = allocator};
    return toliman_fit_create((const toliman_sim *[]){scene}, NULL, 1, &options, (toliman_fit **)out);
}

static toliman_status calibration_in(const toliman_allocator *allocator, void **out) {
    const toliman_calibration_options options = {
        .struct_size = sizeof options, .allocator = allocator, .free = "scale", .threads = 1};
    return toliman_calibration_create(scene, PLAIN_IMAGE(two_frames), 2, NULL, &options, (toliman_calibration **)out);
}

static toliman_status bank_in(const toliman_allocator *allocator, void **out) {
    const toliman_bank_options options = {.struct_size = sizeof options, .allocator = allocator, .places = 2};
    return toliman_bank_create(fit, &options, (toliman_bank **)out);
}

static toliman_status components_in(const toliman_allocator *allocator, void **out) {
    const toliman_components_options options = {
        .struct_size = sizeof options, .capacity = COLLECTED, .allocator = allocator};
    return toliman_components_create(scene, &options, (toliman_components **)out);
}

static toliman_status period_in(const toliman_allocator *allocator, void **out) {
    const toliman_period_options options = {.struct_size = sizeof options, .allocator = allocator};
    return toliman_period_create(0.1, 0.01, FREQUENCIES, &options, (toliman_period **)out);
}

/* From bytes, and from their file. */
#define LOADED(type, bytes, size, path)                                                                                \
    static toliman_status loaded_##type##_in(const toliman_allocator *allocator, void **out) {                         \
        const toliman_load_options options = {.struct_size = sizeof options, .allocator = allocator};                  \
        return toliman_##type##_load(bytes, size, &options, (toliman_##type **)out);                                   \
    }                                                                                                                  \
    static toliman_status type##_file_in(const toliman_allocator *allocator, void **out) {                             \
        const toliman_load_options options = {.struct_size = sizeof options, .allocator = allocator};                  \
        return toliman_##type##_load_file(path, &options, (toliman_##type **)out);                                     \
    }
LOADED(cae, weights, weights_size, weights_file)
LOADED(bank, bank_bytes, bank_size, bank_file)
LOADED(period, state, state_size, state_file)

static toliman_status tracker_in(const toliman_allocator *allocator, const char *place, void **out) {
    const toliman_track_options options = {.struct_size = sizeof options,
                                           .allocator = allocator,
                                           .estimator.linear = estimator,
                                           .folder = place,
                                           .ledger.capacity = TRACKED,
                                           .grid = {.f0 = 0.01, .df = 0.001, .nf = FREQUENCIES}};
    return toliman_track_create(&options, (toliman_track **)out);
}

static toliman_status track_in(const toliman_allocator *allocator, void **out) {
    return tracker_in(allocator, NULL, out);
}

static toliman_status track_folder_in(const toliman_allocator *allocator, void **out) {
    return tracker_in(allocator, folder, out);
}

#define DESTROYS(type) (void (*)(void *)) toliman_##type##_destroy

static const struct kind {
    const char *name;
    toliman_status (*make)(const toliman_allocator *, void **);
    void (*end)(void *);
    size_t least; /* bytes that the object needs at least */
} kinds[] = {{"sim", sim_in, DESTROYS(sim), 2 * kPixels * 8},
             {"sim of four threads", sim_of_threads_in, DESTROYS(sim), 2 * kPixels * 8},
             {"cae", cae_in, DESTROYS(cae), 4 * kPixels * 4},
             {"cae_load", loaded_cae_in, DESTROYS(cae), 4 * kPixels * 4},
             {"cae_load_file", cae_file_in, DESTROYS(cae), 4 * kPixels * 4},
             {"linear", linear_in, DESTROYS(linear), 2 * kPixels * 8},
             {"fit", fit_in, DESTROYS(fit), 2 * kPixels * 8},
             {"calibration", calibration_in, DESTROYS(calibration), 3 * kPixels * 8},
             {"bank", bank_in, DESTROYS(bank), 4 * kPixels * 4},
             {"bank_load", loaded_bank_in, DESTROYS(bank), 4 * kPixels * 4},
             {"bank_load_file", bank_file_in, DESTROYS(bank), 4 * kPixels * 4},
             {"components", components_in, DESTROYS(components), (size_t)COLLECTED *kPixels * 4},
             {"period", period_in, DESTROYS(period), FREQUENCIES * 100},
             {"period_load", loaded_period_in, DESTROYS(period), FREQUENCIES * 100},
             {"period_load_file", period_file_in, DESTROYS(period), FREQUENCIES * 100},
             {"track", track_in, DESTROYS(track), TRACKED * 80 + FREQUENCIES * 100},
             {"track with a folder", track_folder_in, DESTROYS(track), TRACKED * 24 + FREQUENCIES * 100}};
enum { KINDS = sizeof kinds / sizeof *kinds };

FIXTURE(set_up) {
    void *made[6] = {NULL};
    make_folder(folder, sizeof folder);
    assert_ok(sim_in(NULL, &made[0]));
    scene = made[0];
    assert_ok(toliman_sim_frame(scene, NULL, 1, 0, 2, two_frames));
    assert_ok(cae_in(NULL, &made[1]));
    assert_ok(linear_in(NULL, &made[2]));
    assert_ok(period_in(NULL, &made[3]));
    assert_ok(fit_in(NULL, &made[4])); /* FFTW keeps memory of its first plan */
    fit = made[4];
    assert_ok(bank_in(NULL, &made[5]));
    estimator = made[2];
    assert_asks(toliman_cae_save(made[1], NULL, NULL, 0, &weights_size));
    assert_asks(toliman_period_save(made[3], NULL, 0, &state_size));
    weights = malloc(weights_size);
    state = malloc(state_size);
    assert_ok(toliman_cae_save(made[1], NULL, weights, weights_size, &weights_size));
    assert_ok(toliman_period_save(made[3], state, state_size, &state_size));
    snprintf(weights_file, sizeof weights_file, "%s.tlmw", folder);
    snprintf(state_file, sizeof state_file, "%s.tlmp", folder);
    assert_ok(toliman_cae_save_file(made[1], NULL, weights_file));
    assert_ok(toliman_period_save_file(made[3], state_file));
    assert_asks(toliman_bank_save(made[5], 0, NULL, 0, &bank_size));
    bank_bytes = malloc(bank_size);
    assert_ok(toliman_bank_save(made[5], 0, bank_bytes, bank_size, &bank_size));
    snprintf(bank_file, sizeof bank_file, "%s.tlmb", folder);
    assert_ok(toliman_bank_save_file(made[5], 0, bank_file));
    toliman_bank_destroy(made[5]), toliman_period_destroy(made[3]), toliman_cae_destroy(made[1]);
    return 0;
}

FIXTURE(tear_down) {
    unlink(weights_file);
    unlink(state_file);
    unlink(bank_file);
    free(bank_bytes), toliman_fit_destroy(fit), free(weights), free(state), toliman_linear_destroy(estimator);
    toliman_sim_destroy(scene);
    remove_folder(folder);
    return 0;
}

/* Bytes currently allocated by malloc. */
static size_t system_bytes(void) {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/* promise: allocators-get-memory-back */
TEST(large_arrays_come_from_the_caller) {
    for (size_t i = 0; i < KINDS; i++) {
        arena memory = {.fails_at = SIZE_MAX};
        const toliman_allocator allocator = allocator_of(&memory);
        void *made = NULL, *usual = NULL;
        const size_t before = system_bytes();
        assert_ok(kinds[i].make(&allocator, &made));
        const size_t from_system = system_bytes() - before;
        printf("%-20s holds %9zu bytes of %9zu allocated; %8zu of the system's\n", kinds[i].name, memory.held,
               memory.all, from_system);
        assert_true(memory.held >= kinds[i].least);
        assert_true(from_system <= memory.held / 50 + 60000);
        kinds[i].end(made);
        assert_int_equal(memory.held, 0);
        const size_t calls = memory.calls;
        assert_ok(kinds[i].make(NULL, &usual));
        kinds[i].end(usual);
        assert_int_equal(memory.calls, calls);
    }
}

/* One allocation after the other fails; from the 8th on, only some of them. */
/* promise: allocators-get-memory-back */
TEST(no_memory_is_an_error) {
    for (size_t i = 0; i < KINDS; i++) {
        arena memory = {.fails_at = 0};
        const toliman_allocator allocator = allocator_of(&memory);
        void *made = NULL;
        toliman_status status;
        while ((status = kinds[i].make(&allocator, &made)) != TOLIMAN_OK) {
            assert_int_equal(status, TOLIMAN_E_MEMORY);
            assert_non_null(strstr(toliman_last_error(), "out of memory: cannot allocate "));
            assert_null(made);
            assert_int_equal(memory.held, 0);
            memory.calls = 0;
            memory.fails_at += 1 + (memory.fails_at > 8 ? memory.fails_at / 2 : 0);
        }
        kinds[i].end(made);
        assert_int_equal(memory.held, 0);
        assert_true(memory.fails_at > 0);
    }
}

/* A copy uses the same allocator; scratch memory of a call does not come from it. */
/* promise: allocators-get-memory-back */
TEST(memory_belongs_to_its_object) {
    arena memory = {.fails_at = SIZE_MAX};
    const toliman_allocator allocator = allocator_of(&memory);
    void *made = NULL;
    toliman_period *copy = NULL;
    assert_ok(period_in(&allocator, &made));
    const size_t held = memory.held;
    assert_ok(toliman_period_copy(made, &copy));
    assert_int_equal(memory.held, 2 * held);
    double t[20], y[20];
    for (int i = 0; i < 20; i++) {
        t[i] = i;
        y[i] = i % 3;
    }
    assert_ok(toliman_period_push_many(made, t, y, NULL, 20));
    toliman_period_peak peak = {.struct_size = sizeof peak};
    const size_t calls = memory.calls;
    assert_ok(toliman_period_query_fit(made, t, y, NULL, NULL, 20, &peak));
    assert_ok(toliman_period_merge(copy, made));
    assert_int_equal(memory.calls, calls);
    toliman_period_destroy(made);
    assert_int_equal(memory.held, held);
    toliman_period_destroy(copy);
    assert_int_equal(memory.held, 0);
}

TEST(halves_of_an_allocator_are_refused) {
    arena memory = {.fails_at = SIZE_MAX};
    const toliman_allocator whole = allocator_of(&memory);
    const struct {
        toliman_allocator allocator;
        const char *field;
    } cases[] = {{{sizeof whole, 0, whole.allocate, NULL, &memory}, "allocator->release"},
                 {{sizeof whole, 0, NULL, whole.release, &memory}, "allocator->allocate"},
                 {{sizeof whole, 1, whole.allocate, whole.release, &memory}, "allocator->reserved"},
                 {{4, 0, whole.allocate, whole.release, &memory}, "allocator->struct_size"}};
    void *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_invalid(period_in(&cases[i].allocator, &made), cases[i].field);
    assert_null(made);
}

/* promise: zero-is-the-default */
TEST(load_options_are_checked_and_zero_is_their_default) {
    toliman_load_options filled, options = TOLIMAN_LOAD_OPTIONS_INIT;
    memset(&filled, 0xff, sizeof filled);
    filled = (toliman_load_options)TOLIMAN_LOAD_OPTIONS_INIT;
    assert_memory_equal(&filled, &options, sizeof options);
    toliman_period *made = NULL;
    assert_ok(toliman_period_load(state, state_size, &options, &made));
    toliman_period_destroy(made);
    made = NULL;
    options.struct_size = 4;
    assert_invalid(toliman_period_load_file(state_file, &options, &made), "options->struct_size");
    assert_null(made);
}

RUN_TESTS(set_up, tear_down)
