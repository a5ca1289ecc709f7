/* Tests NumPy arrays named by a scene: other files are refused, and headers of all versions are read. */
#include "scene_files.h"

enum { SIDE = 96, PIXELS = SIDE * SIDE };

static toliman_status create(toliman_sim **sim) {
    char *const text =
        replaced(kBinaryScene, "\"aperture_m\"", "\"aberrations\": {\"opd_file\": \"surface.npy\"}, \"aperture_m\"");
    const toliman_status status = create_in_folder(text, sim);
    free(text);
    return status;
}

/* A file with the given header text, after magic, version and a length field of that version. */
static void write_array(int version, const char *header, const double *data, size_t count) {
    unsigned char bytes[1000 + 8 * PIXELS] = "\x93NUMPY";
    const size_t length = strlen(header), start = version == 1 ? 10 : 12;
    bytes[6] = (unsigned char)version;
    bytes[8] = (unsigned char)length;
    bytes[9] = (unsigned char)(length >> 8);
    memcpy(bytes + start, header, length);
    memcpy(bytes + start + length, data, 8 * count);
    write_file("surface.npy", bytes, start + length + 8 * count);
}

static double data[PIXELS];

TEST(other_files_are_refused) {
    const struct {
        int version;
        const char *header;
    } bad[] = {
        {0, "{'descr': '<f8', 'fortran_order': False, 'shape': (96, 96), }"},
        {4, "{'descr': '<f8', 'fortran_order': False, 'shape': (96, 96), }"},
        {1, "{'fortran_order': False, 'shape': (96, 96), }"},
        {1, "{'descr': '<f8', 'shape': (96, 96), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, }"},
        {1, "{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (96, 96), }"},
        {1, "{'descr': '<f8', 'fortran_order': True, 'shape': (96, 96), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': [96, 96], }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (96), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (96, 96, 1), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 96), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (96, x), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape':"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape':  "},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (1048577, 1), }"},
        {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (18446744073709551617, 1), }"},
    };
    toliman_sim *sim = NULL;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_array(bad[i].version, bad[i].header, data, PIXELS);
        assert_refused(create(&sim), TOLIMAN_E_FORMAT, path_of("surface.npy"));
    }
    write_file("surface.npy", "SIMPLE  =                    T", 30);
    assert_refused(create(&sim), TOLIMAN_E_FORMAT, path_of("surface.npy"));
    assert_null(sim);
}

TEST(headers_of_all_versions) {
    static double opd[PIXELS], bare[PIXELS];
    toliman_sim *sim = sim_of(kBinaryScene);
    assert_ok(toliman_sim_get_pupil(sim, NULL, bare));
    toliman_sim_destroy(sim);
    for (int i = 0; i < PIXELS; i++)
        data[i] = 1e-9 * (i % 5);
    for (int version = 1; version <= 3; version++) {
        write_array(version, "{'descr':'<f8','fortran_order': False, 'shape':  ( 96 ,  96 ) }\n", data, PIXELS);
        assert_ok(create(&sim));
        assert_ok(toliman_sim_get_pupil(sim, NULL, opd));
        for (int i = 0; i < PIXELS; i++)
            assert_true(opd[i] == bare[i] + data[i]);
        toliman_sim_destroy(sim);
    }
}

/* Apertures of zeros and ones in every type are the same. */
TEST(numbers_of_all_types) {
    const char *const types[] = {"|b1", "|u1", "<u2", "<u4", "<u8", "<i2", "<i4", "<i8"};
    static double amplitude[PIXELS], expected[PIXELS];
    unsigned char bytes[8 * PIXELS];
    char *const text = replaced(kBinaryScene, "\"aperture_m\"", "\"amplitude\": {\"file\": \"a.npy\"}, \"aperture_m\"");
    toliman_sim *sim = NULL;
    for (int i = 0; i < PIXELS; i++)
        data[i] = i % 3 != 0;
    write_npy("a.npy", "<f8", "(96, 96)", data, sizeof data);
    assert_ok(create_in_folder(text, &sim));
    assert_ok(toliman_sim_get_pupil(sim, expected, NULL));
    toliman_sim_destroy(sim);
    for (size_t t = 0; t < sizeof types / sizeof *types; t++) {
        const size_t width = (size_t)(types[t][2] - '0');
        memset(bytes, 0, sizeof bytes);
        for (size_t i = 0; i < PIXELS; i++)
            bytes[i * width] = (unsigned char)data[i];
        write_npy("a.npy", types[t], "(96, 96)", bytes, width * PIXELS);
        assert_ok(create_in_folder(text, &sim));
        assert_ok(toliman_sim_get_pupil(sim, amplitude, NULL));
        assert_memory_equal(amplitude, expected, sizeof amplitude);
        toliman_sim_destroy(sim);
    }
    free(text);
}

/* Read by its full path; not supported by the engine that resamples the pupil. */
TEST(files_by_their_path) {
    const char *const keys[] = {"\"amplitude\": {\"file\": ", "\"aberrations\": {\"opd_file\": "};
    for (int key = 0; key < 2; key++) {
        char text[200];
        for (int i = 0; i < PIXELS; i++)
            data[i] = key == 0 ? 1 : 1e-9;
        write_npy("surface.npy", "<f8", "(96, 96)", data, sizeof data);
        snprintf(text, sizeof text, "%s\"%s\"}, \"aperture_m\"", keys[key], path_of("surface.npy"));
        char *const scene = replaced(kBinaryScene, "\"aperture_m\"", text);
        toliman_sim *sim = sim_of(scene);
        toliman_sim_destroy(sim);
        sim = NULL;
        toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
        options.engine = TOLIMAN_SIM_ENGINE_PADDED_FFT;
        assert_refused(toliman_sim_create_json(scene, strlen(scene), "", &options, &sim), TOLIMAN_E_UNSUPPORTED,
                       "telescope");
        free(scene);
    }
}

RUN_TESTS(make_folder, remove_folder)
