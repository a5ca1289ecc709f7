/* Tests the message of every malformed or mislabelled file of an observer: file, line and reason. */
#include "ephemeris_files.h"

static void assert_refused(const char *what, const char *expected) {
    const int32_t status = shim_read_ephemeris(saved());
    if (status != FORMAT || strncmp(shim_message(), path, strlen(path)) != 0 ||
        strstr(shim_message(), expected) == NULL)
        fail_msg("%s: status %d, message \"%s\" does not contain \"%s\"", what, status, shim_message(), expected);
}

/* Wrong tables of the same orbits do not: units of one triple, columns exchanged, rotating axes. */
static void swap_velocities(double s[6], double t) {
    (void)t;
    const double x = s[3];
    s[3] = s[4];
    s[4] = x;
}

static void positions_in_m(double s[6], double t) {
    (void)t;
    for (int k = 0; k < 3; k++)
        s[k] *= 1000;
}

static void velocities_in_m_s(double s[6], double t) {
    (void)t;
    for (int k = 3; k < 6; k++)
        s[k] *= 1000;
}

static void all_in_m(double s[6], double t) {
    positions_in_m(s, t);
    velocities_in_m_s(s, t);
}

static void slow_velocities(double s[6], double t) {
    (void)t;
    for (int k = 3; k < 6; k++)
        s[k] /= 1000;
}

/* Velocities relative to an Earth that rotates about an axis in the plane of the orbit. */
static void rotating(double s[6], double t) {
    const double w = 7.292e-5, c = cos(w * t), n = sin(w * t);
    const double y = c * s[1] + n * s[2], z = -n * s[1] + c * s[2];
    const double vy = c * s[4] + n * s[5] + w * z, vz = -n * s[4] + c * s[5] - w * y;
    s[1] = y;
    s[2] = z;
    s[4] = vy;
    s[5] = vz;
}

/* The axes rotate, the velocities are inertial. */
static void half_rotating(double s[6], double t) {
    double turned[6];
    memcpy(turned, s, sizeof turned);
    rotating(turned, t);
    const double w = 7.292e-5;
    turned[4] -= w * turned[2];
    turned[5] += w * turned[1];
    memcpy(s, turned, sizeof turned);
}

static void blunder(double s[6], double t) {
    s[1] += t == 240 ? 1 : 0;
}

static void fast(double s[6], double t) {
    (void)t;
    for (int k = 0; k < 6; k++)
        s[k] *= k < 3 ? 1 : 1.02;
}

static void heavy(double s[6], double t) {
    const double bend = 4e-4 * t; /* km/s: 0.4 m/s^2 more */
    s[5] += bend;
    s[2] += bend * t / 2;
}

static void mislabelled_messages(void **state) {
    const struct {
        const char *what;
        void (*change)(double s[6], double t);
        const char *expected;
    } cases[] = {
        {"all in m", all_in_m,
         ":19: the position is 6.986e+06 km from the Earth's centre: must be in [6378, 3e6] km; "
         "positions must be in km and velocities in km/s"},
        {"positions in m", positions_in_m, ":19: the position is 6.986e+06 km"},
        {"velocities in m/s", velocities_in_m_s,
         ":19: the speed is 7583.95 km/s: must be at most 12 km/s; positions must be in km and velocities in km/s"},
        {"velocities a thousandth", slow_velocities, ":19: up to line 20, 60 s later, the position changes by 75"},
        {"columns exchanged", swap_velocities, "wrong units, columns or axes"},
        {"rotating axes", rotating, "m/s^2 are not the Earth's attraction: must be at most"},
        {"rotating axes, inertial velocities", half_rotating, "wrong units, columns or axes"},
        {"one digit", blunder, ":22: up to line 23, 60 s later, the position changes by"},
        {"2 % faster", fast, ":19: up to line 20, 60 s later, the position changes by"},
        {"another force", heavy, ":19: up to line 20, 60 s later, the velocity changes by"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Message message = kPlain;
        message.change = cases[i].change;
        put_message(&message);
        assert_refused(cases[i].what, cases[i].expected);
    }
}

/* The line as another text; a text that begins with = replaces its first word only. */
static void change_line(int number, const char *with) {
    static char before[sizeof text];
    memcpy(before, text, sizeof before);
    const char *from = before;
    for (int i = 1; i < number; i++)
        from = strchr(from, '\n') + 1;
    const char *const rest = with[0] == '=' ? strpbrk(from, " ,") : strchr(from, '\n');
    length = (size_t)(from - before);
    put("%s%s", with + (with[0] == '=' ? 1 : 0), rest);
}

typedef struct Fault {
    int line; /* 0: from there on nothing is left */
    const char *with, *expected;
} Fault;

static void malformed_messages(void **state) {
    const Fault faults[] = {
        {1, "CCSDS_OEM_VERS = 4.0", ":1: \"CCSDS_OEM_VERS = 4.0\": CCSDS_OEM_VERS must be 1.0, 2.0 or 3.0"},
        {1, "CCSDS_OEM_VERSION = 2.0", "CCSDS_OEM_VERS must be 1.0, 2.0 or 3.0"},
        {1, "CCSDS_OPM_VERS = 2.0", ":1: \"CCSDS_OPM_VERS = 2.0\": must be an Orbit Ephemeris Message"},
        {1, "<?xml version=\"1.0\"?>", ":1: is XML: must be an Orbit Ephemeris Message in key-value notation"},
        {3, "COMMENT", ":6: CREATION_DATE is missing before META_START"},
        {4, "", ":6: ORIGINATOR is missing before META_START"},
        {4, "ORIGINATR = TEST",
         ":4: ORIGINATR: unknown keyword, did you mean ORIGINATOR?: must be one of CREATION_DATE"},
        {4, "ORIGINATOR =", ":4: ORIGINATOR has no value"},
        {5, "ORIGINATOR = TEST", ":5: ORIGINATOR: duplicate keyword, first in line 4"},
        {5, "2028-01-01T00:00:00 1 2 3 4 5 6", ":5: \"2028-01-01T00:00:00 1 2 3 4 5 6\": must be KEYWORD = value"},
        {7, "", ":18: OBJECT_NAME is missing before META_STOP"},
        {9, "CENTER_NAME = MARS BARYCENTER", ":9: CENTER_NAME = MARS BARYCENTER: must be EARTH"},
        {10, "REF_FRAME = TEME",
         ":10: REF_FRAME = TEME: axes of date differ from those of the ICRS by up to 32 m/s, "
         "1.06 uas: convert the states to GCRF; must be ICRF, GCRF or EME2000"},
        {10, "REF_FRAME = ITRF-97",
         ":10: REF_FRAME = ITRF-97: axes that rotate with the Earth make velocities wrong by "
         "500 m/s, 17 uas"},
        {10, "REF_FRAME = TOD", ":10: REF_FRAME = TOD: axes of date"},
        {10, "REF_FRAME = MOD", ":10: REF_FRAME = MOD: axes of date"},
        {10, "REF_FRAME = TDR", ":10: REF_FRAME = TDR: axes that rotate with the Earth"},
        {10, "REF_FRAME = MCI", ":10: REF_FRAME = MCI: its origin is not the Earth's centre"},
        {10, "REF_FRAME = LVLH", ":10: REF_FRAME = LVLH: must be ICRF, GCRF or EME2000"},
        {10, "REF_FRAME = GCRF [km]", ":10: REF_FRAME = GCRF [km]: must be ICRF"},
        {11, "TIME_SYSTEM = UT1", ":11: TIME_SYSTEM = UT1: it follows the rotation of the Earth"},
        {11, "TIME_SYSTEM = MET", ":11: TIME_SYSTEM = MET: a clock on board has no known relation to TAI; must be UTC"},
        {11, "TIME_SYSTEM = TCG", ":11: TIME_SYSTEM = TCG: it has another rate"},
        {11, "TIME_SYSTEM = LOCAL", ":11: TIME_SYSTEM = LOCAL: must be UTC, TAI, TT, TDB or GPS"},
        {12, "START_TIME = 2028-01-01", ":12: START_TIME = \"2028-01-01\": must be an existing time"},
        {12, "START_TIME = 2028-001T00:00:00Z",
         ":12: START_TIME = \"2028-001T00:00:00Z\": must be an existing time "
         "YYYY-MM-DDThh:mm:ss.s or YYYY-DDDThh:mm:ss.s, with a final Z or +00:00 in UTC only"},
        {12, "START_TIME = 2027-366T00:00:00", ":12: START_TIME = \"2027-366T00:00:00\": must be an existing time"},
        {12, "START_TIME = 1957-12-31T00:00:00",
         ":12: START_TIME = \"1957-12-31T00:00:00\": must be from 1958-01-01 to "
         "2099-12-31"},
        {12, "START_TIME = 2029-01-01T00:00:00",
         ":15: STOP_TIME = 2028-01-01T00:11:00.000000000: must be after "
         "START_TIME"},
        {12, "START_TIME = 2028-01-01T00:00:01",
         ":19: the time 2028-01-01T00:00:00.000000000 is outside START_TIME to "
         "STOP_TIME"},
        {13, "USEABLE_START_TIME = 2027-12-31T23:59:59",
         ":13: USEABLE_START_TIME = 2027-12-31T23:59:59: must be from "
         "START_TIME to STOP_TIME"},
        {13, "USEABLE_START_TIME = 2028-01-01T00:10:30", ":14: USEABLE_STOP_TIME must be after USEABLE_START_TIME"},
        {13, "USABLE_START_TIME = 2028-01-01T00:01:00",
         ":13: USABLE_START_TIME: unknown keyword, did you mean "
         "USEABLE_START_TIME?"},
        {15, "STOP_TIME = 2028-01-01T00:10:59", ":30: the time 2028-01-01T00:11:00.000000000 is outside START_TIME"},
        {19, "", ":13: USEABLE_START_TIME"}, /* see below */
        {20, "2028-01-01T00:01:00 1 2 3 4 5",
         ":20: \"2028-01-01T00:01:00 1 2 3 4 5\": must be a time and 6 or 9 finite "
         "numbers"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 nan 0", ":20: \"2028-01-01T00:01:00 7000 0 0 0 nan 0\": must be"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 1e999 0", "must be a time and 6 or 9 finite numbers"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 7,5 0", "must be a time and 6 or 9 finite numbers"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 7.5 0 0 0", "must be a time and 6 or 9 finite numbers"},
        {20, "=2028-01-01T00:01:60", ":20: time = \"2028-01-01T00:01:60\": must be an existing time"},
        {21, "=2028-01-01T00:01:00",
         ":21: the time, 2028-01-01T00:01:00 TAI, must be after that of the state before, "
         "2028-01-01T00:01:00 TAI"},
        {21, "=2028-01-01T00:00:30", ":21: the time, 2028-01-01T00:00:30 TAI, must be after"},
        {21, "=2028-01-01T00:02:01", ":20: up to line 21, 61 s later, the position changes by"},
        {30, "META_START", ":31: \"COVARIANCE_START\": must be KEYWORD = value or META_STOP"},
        {31, "COVARIANCE_STOP", ":31: \"COVARIANCE_STOP\": must be a time"},
        {34, "", ":31: the file ends before COVARIANCE_STOP"},
        {37, "OBJECT_ID = 2028-002A", ":37: OBJECT_ID = 2028-002A: must be 2028-001A in all segments"},
        {40, "TIME_SYSTEM = TT", ":40: TIME_SYSTEM = TT: must be TAI in all segments"},
        {43, "", ":44: \""},
        {0, "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2028-01-01T00:00:00\n", ":2: the file ends before META_START"},
        {0, "", "is empty"},
        {0, "COMMENT only\n", ":1: unknown column \"COMMENT only\": the header must name one of t_tai_ns"},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        put_message(&kPlain);
        if (faults[i].line > 0) {
            change_line(faults[i].line, faults[i].with);
        } else {
            length = 0;
            put("%s", faults[i].with);
        }
        if (faults[i].line == 19) /* the first state is missing: from 1 min on there are states */
            assert_read();
        else
            assert_refused(faults[i].with, faults[i].expected);
    }
    put_message(&kPlain);
    change_line(13, "USEABLE_START_TIME = 2028-01-01T00:00:00");
    change_line(19, "");
    assert_refused("usable before the first state", ":13: USEABLE_START_TIME = 2028-01-01T00:00:00: must be from the "
                                                    "first to the last state of the segment");
    put_message(&kPlain);
    change_line(15, "STOP_TIME = 2028-01-01T00:21:00");
    for (int i = 0; i < STATES; i++) { /* the second segment again */
        double s[6];
        char line[300];
        orbit(60 * (i + 5), s);
        snprintf(line, sizeof line, "%s %.17g %.17g %.17g %.17g %.17g %.17g", date(kStart + 60 * (i + 5) * kNs, false),
                 s[0] / 1000, s[1] / 1000, s[2] / 1000, s[3] / 1000, s[4] / 1000, s[5] / 1000);
        change_line(SECOND_STATE + i, line);
    }
    change_line(41, "START_TIME = 2028-01-01T00:05:00");
    assert_refused("overlapping segments", ":35: the segment is usable from 2028-01-01T00:05:00 TAI: must not begin "
                                           "before the one before it ends, 2028-01-01T00:10:00 TAI");
    put_message(&kPlain);
    change_line(12, "START_TIME = 2028-01-01T00:00:00|Z");
    *strchr(text, '|') = '\0';
    assert_refused("text after a zero byte", ":12: START_TIME = \"2028-01-01T00:00:00\": must be an existing time");
    put_message(&kPlain);
    for (int line = FIRST_STATE; line < FIRST_STATE + 5; line++)
        change_line(line, "");
    change_line(13, "");
    assert_refused("seven states", ":6: the segment that begins here has 7 states: must have at least 8");
}

static void malformed_tables(void **state) {
    const Fault faults[] = {
        {1, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m",
         ":1: unknown column \"vz_m\", did you mean z_m?: the header must "
         "name one of t_tai_ns (integers), t_utc, t_tai, t_tt, t_tdb, t_gps "
         "(dates), with x_km,y_km,z_km or x_m,y_m,z_m and vx_km_s"},
        {1, "t,x,y,z,vx,vy,vz", ":1: unknown column \"t\""},
        {1, "t_tai_ns,x_m,y_m,z_km,vx_m_s,vy_m_s,vz_m_s", ":1: there is no column z_m: the header"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_km_s,vy_m_s,vz_km_s", ":1: there is no column vy_km_s: the header"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s", ":1: there is no column vz_m_s"},
        {1, "x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s", ":1: there is no column of time"},
        {1, "t_tai_ns,t_utc,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s", ":1: two columns of time, t_utc and t_tai_ns"},
        {1, "t_tai_ns,x_m,y_m,y_m,vx_m_s,vy_m_s,vz_m_s", ":1: duplicate column y_m"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,z_km", ":1: there are 8 columns, not 7"},
        {1, "t_tai_ns;x_m;y_m;z_m;vx_m_s;vy_m_s;vz_m_s", ":1: unknown column \"t_tai_ns;x_m"},
        {1, "t_tai_ns,x_km,y_km,z_km,vx_m_s,vy_m_s,vz_m_s",
         ":2: the position is 6.986e+06 km from the Earth's centre: "
         "must be in [6378, 3e6] km; positions must be in km and "
         "velocities in m/s"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_km_s,vy_km_s,vz_km_s", ":2: the speed is 7583.95 km/s"},
        {1, "t_tai_ns,x_m,y_m,z_m,vy_m_s,vx_m_s,vz_m_s", ":2: up to line 3, 60 s later, the position changes by 75"},
        {1, "", ":2: unknown column \"1830297600000000000\""},
        {3, "1,2,3,4,5,6", ":3: 6 fields: must be 7, as in the header"},
        {3, "1,2,3,4,5,6,7,8", ":3: 8 fields: must be 7, as in the header"},
        {3, "=2028-01-01T00:01:00",
         ":3: t_tai_ns = \"2028-01-01T00:01:00\": must be an integer, nanoseconds since 1970"},
        {3, "=9000000000000000000", ":3: t_tai_ns = \"9000000000000000000\": must be an integer"},
        {3, "=1830297600000000000", ":3: the time, 2028-01-01T00:00:00 TAI, must be after that of the state before"},
        {3, "1830297660000000000,6978000,0,0,0,7600,inf", ":3: vz_m_s = \"inf\": must be a finite number"},
        {3, "1830297660000000000,6978000,,0,0,7600,0", ":3: y_m = \"\": must be a finite number"},
        {3, "1830297660000000000,6978,0,0,0,7600,0", ":3: the position is 6.978 km from the Earth's centre"},
        {3, "1830297660000000000,6978000,0,0,0,7600,0x1p3", ":3: vz_m_s = \"0x1p3\": must be a finite number"},
        {0, "# nothing\n\n",
         "contains no states: must be a CCSDS Orbit Ephemeris Message, or a table whose header names"},
        {0, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s\n", ":1: the segment that begins here has 0 states: must have"},
        {0, "1 25544U 98067A   28001.00000000  .00000000  00000-0  00000-0 0    00\n", ":1: unknown column \"1 25544U"},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        table_of(60, 10);
        if (faults[i].line > 0) {
            change_line(faults[i].line, faults[i].with);
        } else {
            length = 0;
            put("%s", faults[i].with);
        }
        assert_refused(faults[i].with, faults[i].expected);
    }
    unlink(path);
    assert_int_equal(shim_read_ephemeris(path), 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mislabelled_messages),
        cmocka_unit_test(malformed_messages),
        cmocka_unit_test(malformed_tables),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
