/* Tests series of measurements: the same numbers from arrays, text, JSON Lines and .npy; times, exposures and
 * functions; what is refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "measure_arrays.h"
#include "test_folder.h"

#include <toliman/planet.h>

enum { N = 4 };
static const double kTimes[N] = {61041.5, 61042.25, 61044, 61050.5}, kValues[N] = {9.8, 9.9, 10, 9.7},
                    kSigmas[N] = {1e-6, 2e-6, 1e-6, 1e-6};

static toliman_measure_info info_of(const toliman_measure *measure) {
    toliman_measure_info info = TOLIMAN_MEASURE_INFO_INIT;
    assert_ok(toliman_measure_get_info(measure, &info));
    return info;
}

static void assert_values(const toliman_measure *measure, const char *name, const double *expected) {
    double found[N];
    assert_ok(toliman_measure_get_values(measure, name, found, N));
    assert_memory_equal(found, expected, sizeof found);
}

static toliman_status load(const char *text, size_t size, const toliman_measure_options *options,
                           toliman_measure **out) {
    return toliman_measure_load(text, size, "s.csv", options, out);
}

/* The header of NumPy's format 1.0. */
static size_t write_npy(char *out) {
    static const char header[] = "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3), }";
    memcpy(out, "\x93NUMPY\1\0\x76\0", 10);
    memset(out + 10, ' ', 118);
    memcpy(out + 10, header, sizeof header - 1);
    out[127] = '\n';
    for (int i = 0; i < N; i++) {
        const double row[3] = {kTimes[i], kValues[i], kSigmas[i]};
        memcpy(out + 128 + (size_t)i * sizeof row, row, sizeof row);
    }
    return 128 + N * 3 * sizeof(double);
}

/* promise: sources-give-same-numbers */
TEST(every_source_gives_the_same_numbers) {
    char texts[3][600];
    size_t sizes[3] = {0, 0, write_npy(texts[2])};
    sizes[0] = (size_t)snprintf(texts[0], sizeof *texts, "# a comment\nmjd,y,other,sigma\n");
    for (int i = 0; i < N; i++) {
        sizes[0] += (size_t)snprintf(texts[0] + sizes[0], sizeof *texts - sizes[0], "%.17g,%.17g,x,%.17g\n", kTimes[i],
                                     kValues[i], kSigmas[i]);
        sizes[1] +=
            (size_t)snprintf(texts[1] + sizes[1], sizeof *texts - sizes[1],
                             "{\"mjd\": %.17g, \"y\": %.17g, \"sigma\": %.17g}\n", kTimes[i], kValues[i], kSigmas[i]);
    }
    const toliman_measure_options plain = {.struct_size = sizeof plain, .flags = TOLIMAN_SERIES_PLAIN_TIMES};
    toliman_measure *made = NULL;
    for (int source = 0; source < 3; source++) {
        assert_ok(load(texts[source], sizes[source], &plain, &made));
        const toliman_measure_info info = info_of(made);
        assert_true(info.n == N && info.is_weighted == 1 && info.has_exposures == 0 && info.time_format == 0);
        assert_int_equal(info.kind, TOLIMAN_MEASURE_VALUE);
        assert_values(made, "t", kTimes);
        assert_values(made, "y", kValues);
        assert_values(made, "sigma", kSigmas);
        toliman_measure_destroy(made);
    }
    made = measure_of(kTimes, kValues, kSigmas, N);
    assert_values(made, "t", kTimes);
    assert_values(made, "sigma", kSigmas);
    toliman_measure_destroy(made);
}

/* Days of UTC become those of TAI, and exposures about them. */
TEST(times_are_those_of_the_exposures) {
    static const char text[] = "mjd,y\n61041.5,9.8\n61042.5,9.9\n";
    const toliman_measure_options options = {
        .struct_size = sizeof options, .kind = TOLIMAN_MEASURE_SEPARATION, .exposure_s = 60};
    toliman_measure *made = NULL, *same = NULL;
    assert_ok(load(text, sizeof text - 1, &options, &made));
    int64_t times[2], again[2];
    const int64_t noon = INT64_C(86400) * (61041 - 40587) + 43200 + 37;
    assert_ok(toliman_measure_get_times(made, times, 2));
    for (int i = 0; i < 2; i++) /* a Modified Julian Day resolves 0.6 us */
        assert_true(llabs(times[i] - (noon + i * 86400) * 1000000000) < 1000);
    assert_int_equal(info_of(made).time_scale, TOLIMAN_INGEST_SCALE_TAI);
    int64_t pairs[4];
    for (int i = 0; i < 4; i++)
        pairs[i] = times[i / 2] + (i % 2 == 0 ? -1 : 1) * INT64_C(30000000000);
    const double values[] = {9.8, 9.9};
    assert_ok(measure_separations(pairs, NULL, values, NULL, 2, &same));
    assert_ok(toliman_measure_get_times(same, again, 2));
    assert_memory_equal(again, times, sizeof times);
    double reduced[2][2];
    toliman_sky *sky = NULL;
    const toliman_sky_options orbit = {.struct_size = sizeof orbit, .altitude_km = 600};
    assert_ok(toliman_sky_create("alpha-cen", &orbit, &sky));
    for (int i = 0; i < 2; i++) {
        toliman_measure *result = NULL;
        assert_ok(toliman_sky_reduce(sky, i == 0 ? made : same, NULL, &result));
        assert_ok(toliman_measure_get_values(result, "y", reduced[i], 2));
        toliman_measure_destroy(result);
    }
    assert_memory_equal(reduced[0], reduced[1], sizeof *reduced);
    toliman_sky_destroy(sky), toliman_measure_destroy(same), toliman_measure_destroy(made);
}

/* T_j(cos x) = cos(j x); columns keep their values. */
TEST(functions_are_polynomials_and_columns) {
    toliman_measure *const made = measure_of(kTimes, kValues, kSigmas, N);
    assert_ok(toliman_measure_set_trend(made, 3, 0, 0));
    assert_ok(toliman_measure_add_column(made, "a column", kSigmas, N, 0.5));
    assert_ok(toliman_measure_set_prior(made, 1, 2));
    assert_values(made, "a column", kSigmas);
    for (int order = 1; order <= 3; order++) {
        char name[4];
        double found[N];
        snprintf(name, sizeof name, "T%d", order);
        assert_ok(toliman_measure_get_values(made, name, found, N));
        for (int i = 0; i < N; i++) {
            const double x = 2 * (kTimes[i] - kTimes[0]) / (kTimes[N - 1] - kTimes[0]) - 1;
            assert_close(found[i], cos(order * acos(x)), 0, 1e-11);
        }
    }
    const struct {
        const char *name;
        double sigma;
    } expected[] = {{"T1", 0}, {"T2", 2}, {"T3", 0}, {"a column", 0.5}};
    assert_int_equal(info_of(made).functions, 4);
    for (int64_t f = 0; f < 4; f++) {
        toliman_measure_function function = TOLIMAN_MEASURE_FUNCTION_INIT;
        assert_ok(toliman_measure_get_function(made, f, &function));
        assert_string_equal(function.name, expected[f].name);
        assert_close(function.sigma, expected[f].sigma, 1e-15, 0);
    }
    toliman_measure_destroy(made);
}

/* A reduced series has the errors of the orbit, or a trend. */
TEST(a_reduction_adds_its_functions) {
    static int64_t pairs[2 * 20];
    double values[20], sigmas[20];
    for (int i = 0; i < 20; i++) {
        pairs[2 * i] = INT64_C(1798761600000000000) + i * INT64_C(604800000000000);
        pairs[2 * i + 1] = pairs[2 * i] + INT64_C(60000000000);
        values[i] = 9.8;
        sigmas[i] = 1e-6;
    }
    const toliman_sky_options orbit = {.struct_size = sizeof orbit, .altitude_km = 600};
    toliman_sky *sky = NULL;
    assert_ok(toliman_sky_create("alpha-cen", &orbit, &sky));
    for (int weighted = 0; weighted < 2; weighted++) {
        toliman_measure *measured = NULL, *reduced = NULL;
        assert_ok(measure_separations(pairs, NULL, values, weighted ? sigmas : NULL, 20, &measured));
        assert_ok(toliman_sky_reduce(sky, measured, NULL, &reduced));
        const toliman_measure_info info = info_of(reduced);
        assert_int_equal(info.kind, TOLIMAN_MEASURE_REDUCED);
        assert_int_equal(info.trend, weighted ? 0 : 4);
        assert_int_equal(info.columns, weighted ? 7 : 0);
        assert_true(info.parallax_arcsec > 0.7 && info.star_mass[1] > 0.8 && info.unit == 1);
        toliman_measure *again = NULL;
        assert_invalid(toliman_sky_reduce(sky, reduced, NULL, &again), "measured");
        toliman_planet *planets = NULL;
        assert_invalid(toliman_planet_create(measured, NULL, &planets), "series");
        toliman_measure_destroy(reduced), toliman_measure_destroy(measured);
    }
    toliman_sky_destroy(sky);
}

/* The rows of a table of functions are those of the samples. */
TEST(a_table_has_functions) {
    char place[256], path[300], text[600];
    make_folder(place, sizeof place);
    snprintf(path, sizeof path, "%s/f.csv", place);
    size_t size = (size_t)snprintf(text, sizeof text, "mjd,y\n");
    for (int i = 0; i < N; i++)
        size += (size_t)snprintf(text + size, sizeof text - size, "%.17g,%.17g\n", kTimes[i], kValues[i]);
    const struct {
        const char *names, *last; /* of the table */
        int32_t status;
    } cases[] = {{"# a comment\nt,a,b", "", TOLIMAN_OK},
                 {"t,a,b", "61050.5,1,1\n", TOLIMAN_E_FORMAT},
                 {"t,a,y", "", TOLIMAN_E_FORMAT},
                 {"t,a,a", "", TOLIMAN_E_FORMAT},
                 {"t,a", "", TOLIMAN_E_FORMAT},
                 {"1,a,b", "", TOLIMAN_E_FORMAT},
                 {"", "", TOLIMAN_E_FORMAT}};
    const toliman_measure_options options = {.struct_size = sizeof options, .functions = path};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        FILE *const file = fopen(path, "w");
        assert_non_null(file);
        fprintf(file, "%s\n", cases[k].names);
        for (int i = 0; i < N; i++)
            fprintf(file, "%.17g, %.17g, %.17g\n", kTimes[i], kValues[i], kSigmas[i]);
        fprintf(file, "%s", cases[k].last);
        fclose(file);
        toliman_measure *made = NULL;
        if (cases[k].status != TOLIMAN_OK) {
            assert_refused(load(text, size, &options, &made), cases[k].status, path);
            continue;
        }
        assert_ok(load(text, size, &options, &made));
        assert_int_equal(info_of(made).columns, 2);
        assert_values(made, "a", kValues), assert_values(made, "b", kSigmas);
        toliman_measure_destroy(made);
    }
    remove_folder(place);
}

/* A copy has the functions of the original, and the numbers that are given. */
TEST(a_copy_takes_other_numbers) {
    toliman_measure *const made = measure_of(kTimes, kValues, kSigmas, N);
    assert_ok(toliman_measure_set_trend(made, 1, 0, 0));
    assert_ok(toliman_measure_add_column(made, "c", kSigmas, N, 0.5));
    const toliman_measure_data other = {.struct_size = sizeof other,
                                        .kind = TOLIMAN_MEASURE_VELOCITY,
                                        .y = kTimes,
                                        .unit = 1000,
                                        .name = "v.csv",
                                        .original = made};
    toliman_measure *copy = NULL, *plain = NULL;
    assert_ok(toliman_measure_create(&other, &copy));
    const toliman_measure_info info = info_of(copy);
    assert_true(info.kind == TOLIMAN_MEASURE_VELOCITY && info.unit == 1000 && info.functions == 2 && info.n == N);
    assert_string_equal(info.name, "v.csv");
    assert_string_equal(info_of(made).name, "");
    assert_values(copy, "t", kTimes), assert_values(copy, "y", kTimes), assert_values(copy, "sigma", kSigmas);
    assert_values(copy, "c", kSigmas), assert_values(made, "y", kValues);
    const toliman_measure_data times = {.struct_size = sizeof times, .t = kValues, .original = copy};
    assert_ok(toliman_measure_create(&times, &plain));
    assert_true(info_of(plain).trend == 0 && info_of(plain).columns == 1 && info_of(plain).unit == 1000);
    assert_values(plain, "t", kValues), assert_values(plain, "y", kTimes);
    toliman_measure_destroy(plain), toliman_measure_destroy(copy);
    const toliman_measure_data more = {.struct_size = sizeof more, .n = N + 1, .y = kTimes, .original = made};
    assert_invalid(toliman_measure_create(&more, &copy), "data->n");
    toliman_measure_destroy(made);
}

static const char *const kReserved[] = {"t", "y", "sigma", "factor", "position_angle_deg", "T1", "T8"};

TEST(bad_series_are_refused) {
    toliman_measure *made = NULL;
    const double bad[N] = {1, NAN, 3, 4}, zero[N] = {1, 1, 0, 1};
    const int64_t near[2 * N] = {12345, 12346, 12347, 12348, 12349, 12350, 12351, 12352};
    const struct {
        toliman_measure_data data;
        const char *field;
    } cases[] = {{{.kind = 7, .n = N, .t = kTimes, .y = kValues}, "data->kind"},
                 {{.n = N, .y = kValues}, "data->t"},
                 {{.n = N, .t = kTimes}, "data->y"},
                 {{.n = N, .t = bad, .y = kValues}, "t[1]"},
                 {{.n = N, .t = kTimes, .y = bad}, "y[1]"},
                 {{.n = N, .t = kTimes, .y = kValues, .sigma = zero}, "sigma[2]"},
                 {{.kind = TOLIMAN_MEASURE_SEPARATION, .n = N, .t = kTimes, .y = zero}, "y[2]"},
                 {{.n = N, .t = kTimes, .y = kValues, .unit = -1}, "unit"},
                 {{.n = N, .t = kTimes, .y = kValues, .time_unit_days = NAN}, "data->time_unit_days"},
                 {{.n = N, .t = kTimes, .y = kValues, .frame_chi_square = -1}, "data->frame_chi_square"},
                 {{.n = N, .y = kValues, .intervals = near}, "intervals"},
                 {{.kind = TOLIMAN_MEASURE_VELOCITY, .n = N, .t = kTimes, .y = kValues, .position_angle_deg = kTimes},
                  "data->position_angle_deg"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_measure_data data = cases[i].data;
        data.struct_size = sizeof data;
        assert_invalid(toliman_measure_create(&data, &made), cases[i].field);
    }
    const struct {
        const char *text;
        int32_t status;
        const char *field;
    } texts[] = {{"", TOLIMAN_E_FORMAT, "s.csv"},
                 {"t,y\n", TOLIMAN_E_FORMAT, "s.csv"},
                 {"1,2\nx,3\n", TOLIMAN_E_FORMAT, "t"},
                 {"a,b\n1,2\n", TOLIMAN_E_MISMATCH, "t"},
                 {"\x93NUMPY", TOLIMAN_E_FORMAT, "s.csv"}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        assert_refused(load(texts[i].text, strlen(texts[i].text), NULL, &made), texts[i].status, texts[i].field);
    assert_fails(load("1,2\nx,3\n", 8, NULL, &made), TOLIMAN_E_FORMAT, "s.csv:2: ");
    const toliman_measure_options long_ones = {.struct_size = sizeof long_ones, .exposure_s = 1e9};
    assert_invalid(load("1,2\n", 4, &long_ones, &made), "options->exposure_s");
    const toliman_measure_options undated = {.struct_size = sizeof undated, .exposure_s = 60};
    assert_invalid(load("1,2\n", 4, &undated, &made), "t");
    const toliman_measure_options growing = {.struct_size = sizeof growing, .flags = TOLIMAN_SERIES_GROWING};
    assert_invalid(load("1,2\n", 4, &growing, &made), "options->flags");
    char table[600];
    const toliman_measure_options named = {.struct_size = sizeof named, .columns = "t,y"};
    assert_invalid(load(table, write_npy(table), &named, &made), "options->columns");
    assert_refused(toliman_measure_load_file("no/such/file", NULL, &made), TOLIMAN_E_NOT_FOUND, "no/such/file");
    assert_null(made);
    made = measure_of(kTimes, kValues, NULL, N);
    double values[N];
    int64_t times[N];
    toliman_measure_function function = TOLIMAN_MEASURE_FUNCTION_INIT;
    assert_refused(toliman_measure_get_values(made, "sigma", values, N), TOLIMAN_E_NOT_FOUND, "name");
    assert_invalid(toliman_measure_get_values(made, "y", values, 3), "n");
    assert_invalid(toliman_measure_get_times(made, times, N), "t");
    assert_refused(toliman_measure_get_function(made, 0, &function), TOLIMAN_E_RANGE, "index");
    assert_refused(toliman_measure_set_prior(made, -1, 1), TOLIMAN_E_RANGE, "function");
    assert_invalid(toliman_measure_set_trend(made, 9, 0, 0), "order");
    assert_invalid(toliman_measure_set_trend(made, 1, 2, 1), "trend");
    assert_invalid(toliman_measure_add_column(made, "c", bad, N, 0), "values[1]");
    assert_invalid(toliman_measure_add_column(made, "c", kValues, 3, 0), "n");
    assert_invalid(toliman_measure_add_column(made, "", kValues, N, 0), "name");
    assert_invalid(toliman_measure_add_column(made, "c", kValues, N, -1), "sigma");
    for (size_t i = 0; i < sizeof kReserved / sizeof *kReserved; i++)
        assert_invalid(toliman_measure_add_column(made, kReserved[i], kValues, N, 0), "name");
    assert_invalid(toliman_measure_set_trend(made, 1, -1e300, 1e300), "start");
    assert_ok(toliman_measure_add_column(made, "c", kValues, N, 0));
    assert_invalid(toliman_measure_add_column(made, "c", kValues, N, 0), "name");
    assert_string_equal(toliman_constant_name(TOLIMAN_MEASURE_REDUCED), "reduced");
    assert_string_equal(toliman_constant_name(15), "?");
    toliman_measure_destroy(made), toliman_measure_destroy(NULL);
}

RUN_TESTS(NULL, NULL)
