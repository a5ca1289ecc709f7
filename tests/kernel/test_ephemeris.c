/* Tests states from the files of an observer: accuracy of the interpolation against analytic orbits, time systems,
 * segments, and that correct files are accepted. */
#include "ephemeris_files.h"

/* Over three revolutions, from one to the other end of the table. */
TEST(accuracy_against_the_orbit) {
    const struct {
        double step, middle_m_s, whole_m_s, position_m;
    } cases[] = {{60, 6e-8, 3e-6, 1e-2}, {120, 2e-5, 1e-3, 1}, {300, 0.03, 0.5, 400}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double step = cases[k].step, span = 18000;
        const int count = (int)(span / step) + 1;
        table_of(step, count);
        assert_read();
        assert_string_equal(shim_warning(), "");
        double whole = 0, middle = 0, position = 0;
        for (double t = 0; t <= span; t += 7.25) {
            double found[6], expected[6];
            assert_int_equal(shim_ephemeris_at(kStart + (int64_t)(t * 1e9), found), 0);
            orbit(t, expected);
            const double error = distance(found + 3, expected + 3);
            whole = fmax(whole, error);
            position = fmax(position, distance(found, expected));
            if (t > 3 * step && t < span - 3 * step)
                middle = fmax(middle, error);
        }
        print_message("steps of %g s: velocity within %.2g m/s, at the ends %.2g m/s, position %.2g m\n", step, middle,
                      whole, position);
        assert_at_most(middle, cases[k].middle_m_s);
        assert_at_most(whole, cases[k].whole_m_s);
        assert_at_most(position, cases[k].position_m);
    }
}

/* At the times of the states the numbers are those of the file. */
TEST(states_are_exact) {
    for (double step = 30; step < 60; step += 0.7) {
        table_of(step, 20);
        assert_read();
        for (int i = 0; i < 20; i++) {
            double found[6], expected[6];
            assert_int_equal(shim_ephemeris_at(kStart + (int64_t)(step * i * 1e9), found), 0);
            orbit(step * i, expected);
            for (int k = 0; k < 6; k++)
                assert_true(found[k] == expected[k]);
        }
    }
}

/* All time systems, month and day or day of the year, with Z or without it: the same bits. */
TEST(time_systems) {
    const Message messages[] = {
        kPlain,
        {.system = "UTC", .ahead_ns = -37 * kNs, .end = ""},
        {.system = "UTC", .ahead_ns = -37 * kNs, .end = "Z", .day_of_year = true},
        {.system = "TT", .ahead_ns = 32184 * (kNs / 1000), .end = ""},
        {.system = "TDB", .ahead_ns = 32184 * (kNs / 1000), .end = "", .day_of_year = true},
        {.system = "GPS", .ahead_ns = -19 * kNs, .end = ""},
    };
    double first[6];
    for (size_t k = 0; k < sizeof messages / sizeof *messages; k++) {
        put_message(&messages[k]);
        assert_read();
        assert_int_equal(shim_segments(), 2);
        int64_t times[3];
        assert_int_equal(shim_segment(0, times), STATES);
        assert_true(times[0] == kStart && times[1] == kStart + 60 * kNs && times[2] == kStart + 600 * kNs);
        assert_int_equal(shim_segment(1, times), STATES);
        assert_true(times[0] == kStart + 660 * kNs && times[1] == times[0] && times[2] == kStart + 1320 * kNs);
        double found[6];
        assert_int_equal(shim_ephemeris_at(kStart + 333 * kNs + 7, found), 0);
        if (k == 0)
            memcpy(first, found, sizeof first);
        assert_memory_equal(found, first, sizeof first);
    }
}

/* The same numbers in a table in km and in a message: the same bits. Columns in any order, one triple in m. */
TEST(table_and_message) {
    double message[6], table[6], mixed[6];
    put_message(&kPlain);
    assert_read();
    assert_int_equal(shim_ephemeris_at(kStart + 1000 * kNs + 1, message), 0);
    length = 0;
    put("\xef\xbb\xbf# states of the second segment\nt_gps,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s # GCRF\n");
    for (int i = STATES - 1; i < 2 * STATES - 1; i++) {
        double s[6];
        orbit(60 * i, s);
        put("%s", date(kStart + (60 * i - 19) * kNs, false));
        for (int k = 0; k < 6; k++)
            put(", %.17g", s[k] / 1000);
        put("\n");
    }
    assert_read();
    assert_int_equal(shim_ephemeris_at(kStart + 1000 * kNs + 1, table), 0);
    assert_memory_equal(message, table, sizeof table);
    length = 0;
    put("vz_m_s,z_km,y_km,x_km,t_tai_ns,vx_m_s,vy_m_s\n");
    for (int i = STATES - 1; i < 2 * STATES - 1; i++) {
        double s[6];
        orbit(60 * i, s);
        put("%.17g,%.17g,%.17g,%.17g,%" PRId64 ",%.17g,%.17g\r\n\r\n", s[5], s[2] / 1000, s[1] / 1000, s[0] / 1000,
            kStart + 60 * i * kNs, s[3], s[4]);
    }
    assert_read();
    assert_int_equal(shim_ephemeris_at(kStart + 1000 * kNs + 1, mixed), 0);
    for (int k = 0; k < 6; k++)
        assert_close(mixed[k], message[k], 0, 1e-8);
}

/* The velocity changes by 5 m/s at the boundary, and is that of one segment on either side. */
TEST(manoeuvre) {
    Message message = kPlain;
    message.kick_m_s = 5;
    put_message(&message);
    char *const useable = strstr(text, "USEABLE_STOP_TIME = 2028-01-01T00:10:00");
    assert_non_null(useable);
    memcpy(useable + strlen("USEABLE_STOP_TIME = 2028-01-01T00:1"), "1", 1);
    assert_read();
    double found[6], expected[6];
    for (int t = 600; t <= 720; t++) {
        assert_int_equal(shim_ephemeris_at(kStart + t * kNs, found), 0);
        orbit(t, expected);
        expected[5] += t >= 660 ? 5 : 0;
        assert_close(distance(found + 3, expected + 3), 0, 0, 1e-5);
    }
    assert_int_equal(shim_ephemeris_at(kStart + 660 * kNs - 1, found), 0);
    orbit(660, expected);
    assert_close(found[5], expected[5], 0, 1e-5);
}

static void assert_no_state(int64_t tai_ns, const char *expected) {
    double found[6];
    assert_int_equal(shim_ephemeris_at(tai_ns, found), RANGE);
    if (strstr(shim_message(), expected) == NULL)
        fail_msg("message \"%s\" does not contain \"%s\"", shim_message(), expected);
}

TEST(times_without_a_state) {
    put_message(&kPlain);
    assert_read();
    double found[6];
    assert_int_equal(shim_ephemeris_at(kStart + 60 * kNs, found), 0);
    assert_no_state(kStart + 60 * kNs - 1, "2028-01-01T00:00:59.999999999 TAI: must be from 2028-01-01T00:01:00 to "
                                           "2028-01-01T00:22:00, the times of the states");
    assert_no_state(kStart + 1320 * kNs + kNs / 2, "2028-01-01T00:22:00.5 TAI: must be from 2028-01-01T00:01:00");
    assert_no_state(INT64_MIN, "1677-09-21T00:12:43.145224192 TAI: must be from");
    assert_no_state(INT64_MAX, "2262-04-11T23:47:16.854775807 TAI: must be from");
    assert_no_state(kStart + 630 * kNs, "2028-01-01T00:10:30 TAI is between segments, of which one ends at "
                                        "2028-01-01T00:10:00 and the next begins at 2028-01-01T00:11:00");
}

/* A table without an hour: states at its ends, a warning, and none in its middle. */
TEST(gap_in_a_table) {
    length = 0;
    put("t_tai,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s\n");
    for (int i = 0; i < 200; i++) {
        double s[6];
        const int t = 60 * i + (i < 100 ? 0 : 3600);
        orbit(t, s);
        put("%s,%.4f,%.4f,%.4f,%.7f,%.7f,%.7f\n", date(kStart + t * kNs, true), s[0], s[1], s[2], s[3], s[4], s[5]);
    }
    assert_read();
    if (strstr(shim_warning(), ":101: the next state is 3660 s later, too far to interpolate velocities to 1 m/s") ==
        NULL)
        fail_msg("warning \"%s\"", shim_warning());
    assert_non_null(strstr(shim_warning(), "(1 such places)"));
    assert_no_state(kStart + 7000 * kNs, "the states there are 3660 s apart");
    double worst = 0;
    int given = 0;
    for (int t = 5400; t < 10200; t++) {
        double found[6], expected[6];
        if (shim_ephemeris_at(kStart + t * kNs, found) != 0)
            continue;
        orbit(t, expected);
        worst = fmax(worst, distance(found + 3, expected + 3));
        given++;
    }
    print_message("next to a gap: %d of 4800 s given, velocity within %.2g m/s\n", given, worst);
    assert_at_most(worst, 1);
    assert_true(given > 1200);
}

static void kepler(double e, double period, double t, double state[6]) {
    const double n = 2 * kPi / period, a = cbrt(kGm / (n * n)), mean = remainder(n * t + 0.5, 2 * kPi);
    double anomaly = mean + e * sin(mean);
    for (int i = 0; i < 20; i++)
        anomaly -= (anomaly - e * sin(anomaly) - mean) / (1 - e * cos(anomaly));
    const double b = a * sqrt(1 - e * e), rate = n / (1 - e * cos(anomaly));
    state[0] = a * (cos(anomaly) - e);
    state[1] = 0.6 * b * sin(anomaly);
    state[2] = 0.8 * b * sin(anomaly);
    state[3] = -a * sin(anomaly) * rate;
    state[4] = 0.6 * b * cos(anomaly) * rate;
    state[5] = 0.8 * b * cos(anomaly) * rate;
}

static double rounded(double value, double unit) {
    return round(value / unit) * unit;
}

/* A table of `count` states of a Kepler orbit, rounded to 1 m and 1 mm/s, passes; the last one is off the grid. */
static void assert_passes(double period, double e, double step, int count) {
    static double states[7 * 400];
    for (int i = 0; i < count; i++) {
        double *const to = states + (size_t)(7 * i);
        to[0] = i < count - 1 ? step * i : step * (count - 2) + 0.31 * fmin(step, 1);
        kepler(e, period, to[0], to + 1);
        for (int k = 0; k < 6; k++)
            to[1 + k] = rounded(to[1 + k], k < 3 ? 1 : 1e-3);
    }
    if (shim_check_states(states, (size_t)count) != 0)
        fail_msg("period %g s, e = %g, steps of %g s: %s", period, e, step, shim_message());
}

/* From low to eccentric and distant orbits, dense and with few states per revolution. */
TEST(correct_tables_pass) {
    int count = 0;
    for (double period = 5700; period < 2.4e6; period *= 2.6)
        for (double e = 0; e < 0.95; e += 0.1) {
            const double perigee = cbrt(kGm * period * period / (4 * kPi * kPi)) * (1 - e);
            if (perigee < 6.5e6)
                break;
            for (double step = 0.1; step < period / 20; step *= 2.3) {
                assert_passes(period, e, step, 400);
                assert_passes(period, e, step, 8);
                count++;
            }
        }
    print_message("%d orbits pass\n", count);
    assert_true(count > 100);
    assert_passes(141138.3, 0.6, 6909.19, 400); /* the perigee is not resolved */
    assert_passes(39096.3, 0.7, 1406.31, 400);
}

/* Navigation solutions at 1 s, with 3 m and 20 mm/s of noise, pass; a velocity that is 2 m/s wrong does not. */
TEST(noisy_states_pass) {
    static double states[7 * 1000];
    uint64_t seed = 1;
    for (int biased = 0; biased < 2; biased++) {
        for (int i = 0; i < 1000; i++) {
            double *const to = states + (size_t)(7 * i);
            to[0] = i;
            orbit(to[0], to + 1);
            for (int k = 0; k < 6; k++) {
                seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
                const double uniform = (double)(seed >> 11) / 9007199254740992.0 - 0.5;
                to[1 + k] += uniform * (k < 3 ? 10.4 : 0.07);
            }
            to[5] += 2 * biased;
        }
        assert_int_equal(shim_check_states(states, 1000), biased ? FORMAT : 0);
    }
}

/* Dates of messages against the calendar of the C library. */
TEST(dates_of_messages) {
    for (int64_t day = 0; day < 90000; day += 13) {
        const int64_t ns = day * 86400 * kNs + 12345 * kNs + 123456789;
        char found[64];
        shim_date_text(ns, found, sizeof found);
        assert_string_equal(found, date(ns, false));
    }
}

RUN_TESTS(make_file, remove_file)
