/* Tests spectra in tables: their numbers, units and refusals. */
#include "scene_files.h"

TEST(tables_are_read_and_refused) {
    const char *const body = "{'kind': 'blackbody', 'temperature_k': 5260}";
    const char *const table = "{'kind': 'table', 'file': 'star.csv'}";
    const struct {
        const char *text;
        toliman_status code;
        const char *field; /* NULL: the file */
    } bad[] = {
        {"wavelength_nm,flux\n540,1\n590,1\n", TOLIMAN_E_SCENE, "band"},
        {"540,1\n590,1\n", TOLIMAN_E_SCENE, "band"},
        {"560.5,1\n650,1\n", TOLIMAN_E_SCENE, "band"},
        {"angstrom,flux\n540,1\n600,1\n", TOLIMAN_E_SCENE, "band"},
        {"540,0\n600,0\n", TOLIMAN_E_SCENE, "stars.B.spectrum"},
        {"540,1e308\n600,1e308\n", TOLIMAN_E_SCENE, "stars.B.spectrum"},
        {"540,1\n530,1\n", TOLIMAN_E_SCENE, "band"},
        {"540,1\n530,1\n535,1\n", TOLIMAN_E_FORMAT, NULL},
        {"540,1\n540,1\n", TOLIMAN_E_FORMAT, NULL},
        {"5400,1\n6000,1\n", TOLIMAN_E_FORMAT, NULL},
        {"wavelength,flux\n100,1\n25900,1\n", TOLIMAN_E_FORMAT, NULL},
        {"0.54,1\n0.6,1\n", TOLIMAN_E_FORMAT, NULL},
        {"# wavelength_angstrom flam\n540 1\n600 1\n", TOLIMAN_E_SCENE, "band"},
        {"wavelength flux error\n540 1\n600 1\n", TOLIMAN_E_FORMAT, NULL},
        {"540 1 2\n600 1 2\n", TOLIMAN_E_FORMAT, NULL},
        {"540;1\n600;1\n", TOLIMAN_E_FORMAT, NULL},
        {"540,1\n600\n", TOLIMAN_E_FORMAT, NULL},
        {"540,1\n600,1,2\n", TOLIMAN_E_FORMAT, NULL},
        {"one\ntwo\n", TOLIMAN_E_FORMAT, NULL},
        {"wavelength_nm,flux,sigma\n540,1\n", TOLIMAN_E_FORMAT, NULL},
        {"#\nenergy_ev,flux\n540,1\n", TOLIMAN_E_FORMAT, NULL},
        {"wavelength_nm_um,flux\n540,1\n", TOLIMAN_E_FORMAT, NULL},
        {"nm,magnitude\n540,1\n", TOLIMAN_E_FORMAT, NULL},
        {"nm,photons erg\n540,1\n", TOLIMAN_E_FORMAT, NULL},
        {"# nothing\n", TOLIMAN_E_FORMAT, NULL},
    };
    toliman_sim *sim = NULL;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_file("star.csv", bad[i].text, strlen(bad[i].text));
        assert_refused(create_with(body, table, &sim), bad[i].code,
                       bad[i].field != NULL ? bad[i].field : path_of("star.csv"));
    }
    write_file("star.csv", "540,1\n\n600,-1\n", 14);
    assert_fails(create_with(body, table, &sim), TOLIMAN_E_FORMAT, "line 3: flux = -1");
    unlink(path_of("star.csv"));
    assert_refused(create_with(body, table, &sim), TOLIMAN_E_NOT_FOUND, path_of("star.csv"));
    assert_null(sim);

    const char *const good = "# a comment\r\nwavelength_nm, flux\r\n 500, 1\r\n575 ,2.5e0\r\n600,3";
    write_file("star.csv", good, strlen(good));
    assert_ok(create_with(body, table, &sim));
    double wavelength[5], a[5], b[5];
    assert_ok(toliman_sim_get_spectrum(sim, 5, wavelength, a, b, NULL));
    assert_close(b[0] / b[2], 0.5 * (1 + 1.5 * 50 / 75) / 2.5, 1e-14, 0);
    assert_close(b[1] / b[2], (1 + 1.5 * 62.5 / 75) / 2.5, 1e-14, 0);
    assert_close(b[4] / b[2], 0.5 * 3 / 2.5, 1e-14, 0);
    toliman_sim_destroy(sim);
}

/* The same spectrum in other units: photons per wavelength 1, 2.5 and 3 at 500, 575 and 600 nm. */
TEST(spectra_in_other_units) {
    static const struct {
        const char *header;
        double nm, power;
    } kinds[] = {
        {"", 1, 0},
        {"wavelength,flux", 1, 0},
        {"Wavelength [nm], Photlam", 1, 0},
        {"lambda (\xc3\x85),relative photon flux", 0.1, 0},
        {"wavelength_angstrom,flam", 0.1, 1},
        {"WAVELENGTH_NM,erg/s/cm2/A", 1, 1},
        {"Wavelength (microns), W m-2 \xc2\xb5m-1", 1e3, 1},
        {"wave_um,fnu", 1e3, -1},
        {"nm,Jy", 1, -1},
        {"m,photons/s/m2/nm", 1e9, 0},
    };
    static const double nm[3] = {500, 575, 600}, photons[3] = {1, 2.5, 3};
    double wavelength[5], a[5], b[5], first[5] = {0};
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
        char text[400];
        int at = snprintf(text, sizeof text, "%s\n", kinds[kind].header);
        for (int i = 0; i < 3; i++)
            at += snprintf(text + at, sizeof text - (size_t)at, "%.17g,%.17g\n", nm[i] / kinds[kind].nm,
                           photons[i] * pow(nm[i], -kinds[kind].power));
        write_file("star.csv", text, strlen(text));
        toliman_sim *sim = NULL;
        assert_ok(
            create_with("{'kind': 'blackbody', 'temperature_k': 5260}", "{'kind': 'table', 'file': 'star.csv'}", &sim));
        assert_ok(toliman_sim_get_spectrum(sim, 5, wavelength, a, b, NULL));
        for (int i = 0; i < 5; i++) {
            first[i] = kind == 0 ? b[i] : first[i];
            assert_close(b[i] / first[i], 1, 1e-12, 0);
        }
        toliman_sim_destroy(sim);
    }
}

/* The same spectrum in other forms: blanks, descending, the header in a comment, an ECSV file. */
TEST(spectra_in_other_forms) {
    static const char *const forms[] = {
        "500,1\n575,2.5\n600,3\n",
        "wavelength_nm flux\n500\t1\n575 2.5\n600  3\n",
        "600,3\n575,2.5\n500,1\n",
        "# a star, in air\n# Wavelength (Angstrom)  photlam\n5000 1\n5750 2.5\n6000 3\n",
        ("# %ECSV 1.0\n# ---\n# datatype:\n# - {name: wave, unit: um, datatype: float64}\n"
         "# - {name: flux, unit: W / (m2 um), datatype: float64}\n# schema: astropy-2.0\n"
         "wave flux\n0.5 600\n0.575 1304.3478260869565\n0.6 1500\n"),
        ("# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n# - {name: flux, datatype: float64}\n"
         "# - {name: wavelength, datatype: float64, unit: Angstrom}\nwavelength,flux\n5000,1\n5750,2.5\n6000,3\n"),
    };
    double a[5], b[5], first[5] = {0};
    for (size_t form = 0; form < sizeof forms / sizeof *forms; form++) {
        write_file("star.csv", forms[form], strlen(forms[form]));
        toliman_sim *sim = NULL;
        assert_ok(
            create_with("{'kind': 'blackbody', 'temperature_k': 5260}", "{'kind': 'table', 'file': 'star.csv'}", &sim));
        assert_ok(toliman_sim_get_spectrum(sim, 5, NULL, a, b, NULL));
        for (int i = 0; i < 5; i++) {
            first[i] = form == 0 ? b[i] : first[i];
            assert_close(b[i] / first[i], 1, form == 4 ? 2e-3 : 1e-12, 0); /* linear in energy */
        }
        toliman_sim_destroy(sim);
    }
}

RUN_TESTS(make_folder, remove_folder)
