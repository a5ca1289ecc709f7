/* Tests that every malformed or mislabelled file of an observer is refused with its path, the line and a name in it. */
#include "ephemeris_files.h"

/* line: 0: the message names none. */
static void assert_faulty(const char *what, int line, const char *name) {
    const int32_t status = shim_read_ephemeris(saved());
    char place[400];
    const int size =
        line > 0 ? snprintf(place, sizeof place, "%s:%d: ", path, line) : snprintf(place, sizeof place, "%s", path);
    if (status != FORMAT || strncmp(shim_message(), place, (size_t)size) != 0 || strstr(shim_message(), name) == NULL)
        fail_msg("%s: status %d, message \"%s\": line %d, \"%s\"", what, status, shim_message(), line, name);
}

/* Wrong tables of the same orbits: units of one triple, columns exchanged, rotating axes. */
static double position_scale, velocity_scale;

static void scaled(double s[6], double t) {
    for (int k = 0; k < 6; k++)
        s[k] *= k < 3 ? position_scale : velocity_scale;
}

static void swap_velocities(double s[6], double t) {
    const double x = s[3];
    s[3] = s[4];
    s[4] = x;
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

static void heavy(double s[6], double t) {
    const double bend = 4e-4 * t; /* km/s: 0.4 m/s^2 more */
    s[5] += bend;
    s[2] += bend * t / 2;
}

/* promise: other-axes-are-refused */
TEST(mislabelled_messages) {
    const struct {
        const char *what;
        void (*change)(double s[6], double t);
        double position, velocity;
        int line;
        const char *name;
    } cases[] = {
        {"all in m", scaled, 1000, 1000, 19, "position"},
        {"positions in m", scaled, 1000, 1, 19, "position"},
        {"velocities in m/s", scaled, 1, 1000, 19, "speed"},
        {"velocities a thousandth", scaled, 1, 1e-3, 19, "line 20, 60 s later, the position"},
        {"2 % faster", scaled, 1, 1.02, 19, "line 20, 60 s later, the position"},
        {"columns exchanged", swap_velocities, 1, 1, 19, "position"},
        {"rotating axes", rotating, 1, 1, 19, "m/s^2"},
        {"rotating axes, inertial velocities", half_rotating, 1, 1, 19, "position"},
        {"one digit", blunder, 1, 1, 22, "line 23, 60 s later, the position"},
        {"another force", heavy, 1, 1, 19, "line 20, 60 s later, the velocity"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Message message = kPlain;
        message.change = cases[i].change;
        position_scale = cases[i].position;
        velocity_scale = cases[i].velocity;
        put_message(&message);
        assert_faulty(cases[i].what, cases[i].line, cases[i].name);
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
    int changed; /* line; 0: the text is the whole file */
    const char *with;
    int line; /* of the message, 0: none */
    const char *name;
} Fault;

/* make: the correct file. */
static void assert_all_faulty(void (*make)(void), const Fault *faults, size_t count) {
    for (size_t i = 0; i < count; i++) {
        make();
        if (faults[i].changed > 0) {
            change_line(faults[i].changed, faults[i].with);
        } else {
            length = 0;
            put("%s", faults[i].with);
        }
        assert_faulty(faults[i].with, faults[i].line, faults[i].name);
    }
}

static void plain_message(void) {
    put_message(&kPlain);
}

static void plain_table(void) {
    table_of(60, 10);
}

TEST(malformed_messages) {
    const Fault faults[] = {
        {1, "CCSDS_OEM_VERS = 4.0", 1, "CCSDS_OEM_VERS"},
        {1, "CCSDS_OEM_VERSION = 2.0", 1, "CCSDS_OEM_VERS"},
        {1, "CCSDS_OPM_VERS = 2.0", 1, "CCSDS_OPM_VERS = 2.0"},
        {1, "<?xml version=\"1.0\"?>", 2, "XML"},
        {3, "COMMENT", 6, "CREATION_DATE"},
        {4, "", 6, "ORIGINATOR"},
        {4, "ORIGINATR = TEST", 4, "did you mean ORIGINATOR?"},
        {4, "ORIGINATOR =", 4, "ORIGINATOR"},
        {5, "ORIGINATOR = TEST", 5, "line 4"},
        {5, "2028-01-01T00:00:00 1 2 3 4 5 6", 5, "2028-01-01T00:00:00 1 2 3 4 5 6"},
        {7, "", 18, "OBJECT_NAME"},
        {9, "CENTER_NAME = MARS BARYCENTER", 9, "EARTH"},
        {10, "REF_FRAME = TEME", 10, "TEME"},
        {10, "REF_FRAME = ITRF-97", 10, "ITRF-97"},
        {10, "REF_FRAME = TOD", 10, "TOD"},
        {10, "REF_FRAME = MOD", 10, "MOD"},
        {10, "REF_FRAME = TDR", 10, "TDR"},
        {10, "REF_FRAME = MCI", 10, "MCI"},
        {10, "REF_FRAME = LVLH", 10, "LVLH"},
        {10, "REF_FRAME = GCRF [km]", 10, "GCRF [km]"},
        {11, "TIME_SYSTEM = UT1", 11, "UT1"},
        {11, "TIME_SYSTEM = MET", 11, "MET"},
        {11, "TIME_SYSTEM = TCG", 11, "TCG"},
        {11, "TIME_SYSTEM = LOCAL", 11, "LOCAL"},
        {12, "START_TIME = 2028-01-01", 12, "START_TIME"},
        {12, "START_TIME = 2028-001T00:00:00Z", 12, "START_TIME"},
        {12, "START_TIME = 2027-366T00:00:00", 12, "START_TIME"},
        {12, "START_TIME = 1957-12-31T00:00:00", 12, "START_TIME"},
        {12, "START_TIME = 2029-01-01T00:00:00", 15, "STOP_TIME"},
        {12, "START_TIME = 2028-01-01T00:00:01", 19, "START_TIME"},
        {13, "USEABLE_START_TIME = 2027-12-31T23:59:59", 13, "USEABLE_START_TIME"},
        {13, "USEABLE_START_TIME = 2028-01-01T00:10:30", 14, "USEABLE_STOP_TIME"},
        {13, "USABLE_START_TIME = 2028-01-01T00:01:00", 13, "did you mean USEABLE_START_TIME?"},
        {15, "STOP_TIME = 2028-01-01T00:10:59", 30, "2028-01-01T00:11:00"},
        {20, "2028-01-01T00:01:00 1 2 3 4 5", 20, "6 or 9"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 nan 0", 20, "6 or 9"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 1e999 0", 20, "6 or 9"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 7,5 0", 20, "6 or 9"},
        {20, "2028-01-01T00:01:00 7000 0 0 0 7.5 0 0 0", 20, "6 or 9"},
        {20, "=2028-01-01T00:01:60", 20, "2028-01-01T00:01:60"},
        {21, "=2028-01-01T00:01:00", 21, "2028-01-01T00:01:00 TAI"},
        {21, "=2028-01-01T00:00:30", 21, "2028-01-01T00:00:30 TAI"},
        {21, "=2028-01-01T00:02:01", 20, "line 21, 61 s later"},
        {30, "META_START", 31, "COVARIANCE_START"},
        {31, "COVARIANCE_STOP", 31, "COVARIANCE_STOP"},
        {34, "", 31, "COVARIANCE_STOP"},
        {37, "OBJECT_ID = 2028-002A", 37, "2028-001A"},
        {40, "TIME_SYSTEM = TT", 40, "TAI"},
        {43, "", 44, ""},
        {0, "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2028-01-01T00:00:00\n", 2, "META_START"},
        {0, "", 0, "empty"},
        {0, "COMMENT only\n", 1, "t_tai_ns"},
    };
    assert_all_faulty(plain_message, faults, sizeof faults / sizeof *faults);
    plain_message();
    change_line(19, ""); /* the first state, before the usable ones */
    assert_read();
    change_line(13, "USEABLE_START_TIME = 2028-01-01T00:00:00");
    assert_faulty("usable before the first state", 13, "USEABLE_START_TIME");
    plain_message();
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
    assert_faulty("overlapping segments", 35, "2028-01-01T00:10:00 TAI");
    plain_message();
    change_line(12, "START_TIME = 2028-01-01T00:00:00|Z");
    *strchr(text, '|') = '\0';
    assert_faulty("text after a zero byte", 0, "not a text file");
    plain_message();
    for (int line = FIRST_STATE; line < FIRST_STATE + 5; line++)
        change_line(line, "");
    change_line(13, "");
    assert_faulty("seven states", 6, "7 states");
}

TEST(malformed_tables) {
    const Fault faults[] = {
        {1, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m", 1, "\"vz_m\", did you mean z_m?"},
        {1, "t,x,y,z,vx,vy,vz", 1, "\"t\""},
        {1, "t_tai_ns,x_m,y_m,z_km,vx_m_s,vy_m_s,vz_m_s", 1, "z_m:"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_km_s,vy_m_s,vz_km_s", 1, "vy_km_s:"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s", 1, "vz_m_s"},
        {1, "x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s", 1, "time"},
        {1, "t_tai_ns,t_utc,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s", 1, "t_utc and t_tai_ns"},
        {1, "t_tai_ns,x_m,y_m,y_m,vx_m_s,vy_m_s,vz_m_s", 1, "y_m"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,z_km", 1, "8 columns"},
        {1, "t_tai_ns;x_m;y_m;z_m;vx_m_s;vy_m_s;vz_m_s", 1, "\"t_tai_ns;x_m"},
        {1, "t_tai_ns,x_km,y_km,z_km,vx_m_s,vy_m_s,vz_m_s", 2, "position"},
        {1, "t_tai_ns,x_m,y_m,z_m,vx_km_s,vy_km_s,vz_km_s", 2, "speed"},
        {1, "t_tai_ns,x_m,y_m,z_m,vy_m_s,vx_m_s,vz_m_s", 2, "line 3, 60 s later, the position"},
        {1, "", 2, "\"1830297600000000000\""},
        {3, "1,2,3,4,5,6", 3, "6 fields"},
        {3, "1,2,3,4,5,6,7,8", 3, "8 fields"},
        {3, "=2028-01-01T00:01:00", 3, "t_tai_ns"},
        {3, "=9000000000000000000", 3, "t_tai_ns"},
        {3, "=1830297600000000000", 3, "2028-01-01T00:00:00 TAI"},
        {3, "1830297660000000000,6978000,0,0,0,7600,inf", 3, "vz_m_s"},
        {3, "1830297660000000000,6978000,,0,0,7600,0", 3, "y_m"},
        {3, "1830297660000000000,6978,0,0,0,7600,0", 3, "6.978 km"},
        {3, "1830297660000000000,6978000,0,0,0,7600,0x1p3", 3, "vz_m_s"},
        {0, "# nothing\n\n", 0, "CCSDS"},
        {0, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s\n", 1, "0 states"},
        {0, "1 25544U 98067A   28001.00000000  .00000000  00000-0  00000-0 0    00\n", 1, "\"1 25544U"},
    };
    assert_all_faulty(plain_table, faults, sizeof faults / sizeof *faults);
    unlink(path);
    assert_int_equal(shim_read_ephemeris(path), 4);
}

RUN_TESTS(make_file, remove_file)
