/* Tables as archives, journals and spreadsheets write them: each is read whole and line by line, to the same samples;
 * damaged and ambiguous ones are refused, with line and name. */
#include <stdio.h>
#include <string.h>

#include <toliman/toliman.h>

#include "assert_close.h"

enum { N = 3, UTC_AHEAD_S = 37 };
static const double kTimes[N] = {0, 9.75, 25.25}, kValues[N] = {-7.5, 2.25, 4}, kSigmas[N] = {1, 0.5, 2};
static const double kUtc = 58999.5 + UTC_AHEAD_S / 86400.0; /* JD 2459000.0 of UTC as MJD of TAI */

typedef struct table {
    const char *text;
    double first;              /* the first time */
    const char *unit;          /* of y; NULL: none */
    const char *warning;       /* the only one, or NULL */
    const char *columns;       /* option */
    int64_t missing;           /* rows without a value */
    int32_t unweighted, scale; /* no sigmas; scale of the times, 0: plain numbers */
    int32_t whole_only;        /* no line-by-line reading */
} table;

#define TAI .scale = TOLIMAN_INGEST_SCALE_TAI
#define TDB .scale = TOLIMAN_INGEST_SCALE_TDB
#define ROWS(s) "2459000" s "-7.5" s "1\n2459009.75" s "2.25" s "0.5\n2459025.25" s "4" s "2\n"
#define LESS "5900" /* of JD - 2400000 */

#define MRT_HEAD                                                                                                       \
    "Title: Velocities of a star\nAuthors: A. N. Other\nTable: 3 of 4\n"                                               \
    "================================================================================\n"                               \
    "Byte-by-byte Description of file: table3.txt\n"                                                                   \
    "--------------------------------------------------------------------------------\n"                               \
    "   Bytes Format Units Label  Explanations\n"                                                                      \
    "--------------------------------------------------------------------------------\n"                               \
    "   1-  2 A2     ---   Obs    Observer, A\n"                                                                       \
    "                             or B\n"                                                                              \
    "   4- 13 F10.2  d     BJD    Barycentric Julian Date\n"                                                           \
    "  15- 19 F5.2   km/s  RV     ?=-9.99 Radial velocity\n"                                                           \
    "  21- 26 F6.1   m/s   e_RV   ? Uncertainty in RV\n"                                                               \
    "      28 I1     ---   Flag   ? Quality\n"                                                                         \
    "--------------------------------------------------------------------------------\n"
#define MRT_NOTES                                                                                                      \
    "Note (1): 2459000 -7.5 1 is not a row,\n    and neither is this.\n"                                               \
    "--------------------------------------------------------------------------------\n"
#define MRT_ROWS "A  2459000.00 -7.50 1000.0 1\nB  2459009.75  2.25  500.0\nA  2459025.25  4.00 2000.0 2\n"

static const table kTables[] = {
    /* separators, signs and numbers */
    {ROWS(" "), .first = 2459000},
    {"  2459000\t-7.5  1\n2459009.75\t2.25\t 0.5\n2459025.25 4\t2\n", .first = 2459000},
    {"2459000 -7.5 +- 1\n2459009.75 2.25 +- 0.5\n2459025.25 4 +/- 2\n", .first = 2459000},
    {"2459000 -7.5\xc2\xb1"
     "1\n2459009.75 2.25\xc2\xb1.5\n2459025.25 4 \xc2\xb1 2\n",
     .first = 2459000},
    {"2459000,-7.5+-1\n2459009.75,2.25 +- 0.5\n2459025.25,4 +/- 2\n", .first = 2459000},
    {"t,y,sigma\n2459000,-7.5,1 # good\n2459009.75,2.25,0.5 #\n2459025.25,4,2\t# end\n", .first = 2459000},
    {"t;y;sigma\n2459000;-7,5;1\n2459009,75;2,25;0,5\n2459025,25;4;2\n", .first = 2459000},
    {"2459000,0\t-7,5\t1\n2459009,75\t2,25\t0,5\n2459025,25\t4\t2\n", .first = 2459000},
    {"2.459000D+06 -7.5d0 1.0D0\n2.45900975D6 0.225D+01 5.D-1\n2.45902525D+06 4 2\n", .first = 2459000},
    {"\xef\xbb\xbf\"t\",\"y\",\"sigma\"\r\n2459000,-7.5,1\r\n\"2459009.75\",\"2.25\",\"0.5\"\r\n2459025.25,4,2\r\n",
     .first = 2459000},
    {"note,t,y,sigma\n\"a, b\",2459000,-7.5,1\n\"c \"\"d\"\", e\",2459009.75,2.25,0.5\n,2459025.25,4,2\n",
     .first = 2459000},
    {"t,y\n0,-7.5\n9.75,2.25\n25.25,4\n", .first = 0, .unweighted = 1},
    {ROWS(" ") "# end\n\n", .first = 2459000},
    /* names */
    {"T,Y,SIGMA\n" ROWS(","), .first = 2459000},
    {"bjd,rv,e_rv\n" ROWS(","), .first = kUtc, TAI},
    {"BJD_TDB rv_err RV\n2459000 1 -7.5\n2459009.75 0.5 2.25\n2459025.25 2 4\n", .first = 58999.5, TDB},
    {"hjd vrad svrad\n" ROWS(" "), .first = kUtc, TAI},
    {"BJD-2450000,mnvel,errvel\n9000,-7.5,1\n9009.75,2.25,0.5\n9025.25,4,2\n", .first = kUtc, TAI},
    {"BJD (TDB) - 2400000.5,rv,err\n58999.5,-7.5,1\n59009.25,2.25,0.5\n59024.75,4,2\n", .first = 58999.5, TDB},
    {"time [BJD - 2457000 days];radial_velocity [m/s];uncertainty\n2000;-7.5;1\n2009.75;2.25;0.5\n2025.25;4;2\n",
     .first = kUtc, .unit = "m/s", TAI},
    {"rjd\tvrad\tsvrad\n---\t----\t-----\n59000\t-7.5\t1\n59009.75\t2.25\t0.5\n59025.25\t4\t2\n", .first = kUtc, TAI},
    {"jd,value,error\n59000,-7.5,1\n59009.75,2.25,0.5\n59025.25,4,2\n", .first = kUtc,
     .warning = "s.csv: jd = 59000: the times are taken as JD - 2400000", TAI},
    {"bjd,rv,err\n9000,-7.5,1\n9009.75,2.25,0.5\n9025.25,4,2\n", .first = 9000,
     .warning =
         "s.csv: bjd = 9000: the times are neither Julian Days nor JD - 2400000: they are taken as plain numbers"},
    {"epoch,sep,sep_err\n2000,-7.5,1\n2009.75,2.25,0.5\n2025.25,4,2\n", .first = 2000,
     .warning = "s.csv: epoch = 2000: the times may be years, and are taken as days"},
    {"date,y,sigma\n2020-01-01 00:00:00,-7.5,1\n2020-01-10 18:00:00,2.25,0.5\n2020-01-26T06:00:00,4,2\n",
     .first = 58849 + UTC_AHEAD_S / 86400.0, TAI},
    {"2020-01-01 00:00:00 -7.5 1\n2020-01-10 18:00:00 2.25 0.5\n2020-01-26 06:00:00 4 2\n",
     .first = 58849 + UTC_AHEAD_S / 86400.0, TAI},
    {"mjd,t,y,sigma\n1,2459000,-7.5,1\n2,2459009.75,2.25,0.5\n3,2459025.25,4,2\n", .first = 2459000},
    {"# a list of velocities\n# name t y sigma\nX 2459000 -7.5 1\nX 2459009.75 2.25 0.5\nX 2459025.25 4 2\n",
     .first = 2459000},
    {"# sigma, y, t\n1 -7.5 2459000\n0.5 2.25 2459009.75\n2 4 2459025.25\n", .first = 2459000},
    {"#BJD_TDB RV Error\n#d m/s m/s\n" ROWS(" "), .first = 58999.5, .unit = "m/s", TDB},
    {"# time in days\n" ROWS(" "), .first = 2459000},
    {"2459000 -7.5 1 HARPS 1\n2459009.75 2.25 0.5 HARPS 1\n2459025.25 4 2 HARPS 1\n", .first = 2459000,
     .warning = "s.csv: the columns have no names: columns 1, 2 and 3 of 5 are taken as t, y and sigma"},
    {"A,2459000,1,-7.5\nA,2459009.75,0.5,2.25\nA,2459025.25,2,4\n", .first = 2459000, .columns = "2,4,3"},
    {"a b c\n2459000 -7.5 1\n2459009.75 2.25 0.5\n2459025.25 4 2\n", .first = 2459000, .columns = "1 2 3"},
    {"BJD (TDB),rv (km/s),rv error (m/s)\n2459000,-7.5,1000\n2459009.75,2.25,500\n2459025.25,4,2000\n",
     .first = 58999.5, .unit = "km/s", .columns = "bjd,RV,rv error (m/s)", TDB},
    {"t,y,jitter_err\n0,-7.5,1\n9.75,2.25,1\n25.25,4,1\n", .first = 0,
     .warning = "s.csv: no column is known to be sigma: column jitter_err is not used", .unweighted = 1},
    /* units */
    {"t (d),y (m/s),sigma (m/s)\n" ROWS(","), .first = 2459000, .unit = "m/s"},
    {"t y[km/s] sigma [m s-1]\n2459000 -7.5 1000\n2459009.75 2.25 500\n2459025.25 4 2000\n", .first = 2459000,
     .unit = "km/s"},
    {"t,y,sigma\nd,m/s,m/s\n" ROWS(","), .first = 2459000, .unit = "m/s"},
    {"t\ty\tsigma\n(days)\t(\xc2\xb5"
     "as)\t(mas)\n0\t-7.5\t0.001\n9.75\t2.25\t0.0005\n25.25\t4\t0.002\n",
     .first = 0, .unit = "uas"},
    {"t,flux,error\nd,e/s,e/s\n" ROWS(","), .first = 2459000, .unit = "e/s"},
    /* missing values */
    {"t,y,sigma\n1,,1\n2459000,-7.5,1\n2,nan,1\n3,--,1\n2459009.75,2.25,0.5\n4,1,N/A\n-,1,1\n5,...,1\n6,NULL,1\n"
     "2459025.25,4,2\n7,masked,1\n8,-,1\n",
     .first = 2459000, .warning = "s.csv: 9 of 12 rows have no value and are skipped", .missing = 9},
    {"t\ty\tsigma\n2459000\t-7.5\t1\n5\t\t1\n2459009.75\t2.25\t0.5\n2459025.25\t4\t2\n", .first = 2459000,
     .warning = "s.csv: 1 of 4 rows have no value and are skipped", .missing = 1},
    /* ECSV, rdb, IPAC, byte by byte, bars */
    {"# %ECSV 1.0\n# ---\n# datatype:\n# - {name: bjd_tdb, unit: d, datatype: float64}\n"
     "# - {name: rv, unit: km / s, datatype: float64, description: 'of the, star'}\n"
     "# - {name: rv_err, unit: m / s,\n#   datatype: float64}\n# meta: !!omap\n# - {unit: x}\n# schema: astropy-2.0\n"
     "bjd_tdb rv rv_err\n2459000 -7.5 1000\n2459001 \"\" 1\n2459009.75 2.25 500\n2459025.25 4 2000\n",
     .first = 58999.5, .unit = "km/s", .warning = "s.csv: 1 of 4 rows have no value and are skipped", .missing = 1,
     TDB},
    {"# %ECSV 0.9\n# ---\n# delimiter: ','\n# datatype:\n# -\n#   name: x\n# - name: t\n#   unit: d\n#   datatype: "
     "float64\n"
     "# - name: y\n#   datatype: float64\n#   unit: mas\nt,y,sigma\n" ROWS(","),
     .first = 2459000, .unit = "mas"},
    {"bjd\tvrad\tsvrad\n10.5N\t8N\t6N\n" ROWS("\t"), .first = kUtc, TAI},
    {"#RESOURCE=yCat\n#Column\tHJD\nHJD\tRV\te_RV\nd\tkm/s\tm/s\n----------\t------\t------\n2459000\t-7.5\t1000\n"
     "2459009.75\t2.25\t 500\n2459025.25\t4\t2000\n",
     .first = kUtc, .unit = "km/s", TAI},
    {"\\fixlen = T\n\\ a comment\n|bjd       |rv     |rv_err|\n|double    |double |double|\n|d         |km/s   |m/s   "
     "|\n"
     "|          |-99    |null  |\n 2459000    -7.5    1000.\n 2459009     -99    1000.\n 2459009.75  2.25    500.\n"
     " 2459025.25  4      2000.\n",
     .first = kUtc, .unit = "km/s", .warning = "s.csv: 1 of 4 rows have no value and are skipped", .missing = 1, TAI},
    {"|t   |y   |sigma|\n|double|double|double|\n|d|m/s|m/s|\n" ROWS(" "), .first = 2459000, .unit = "m/s"},
    {MRT_HEAD MRT_ROWS, .first = kUtc, .unit = "km/s", TAI},
    {MRT_HEAD MRT_NOTES "A  2459001.00 -9.99 1000.0 1\nA  2459001.00  1.00\n" MRT_ROWS, .first = kUtc, .unit = "km/s",
     .warning = "s.csv: 2 of 5 rows have no value and are skipped", .missing = 2, TAI},
    {"HJD|RV|e_RV\nd|km/s|m/s\n-------|----|---\n2459000|-7.5|1000\n2459009.75| 2.25|500\n2459025.25|4|2000\n",
     .first = kUtc, .unit = "km/s", TAI},
    {"# x\nHJD;RV;e_RV\nd;km/s;m/s\n---;---;---\n2459000;-7.5;1000\n2459009.75;2.25;500\n2459025.25;4;2000\n",
     .first = kUtc, .unit = "km/s", TAI},
    {"t,y (\xb5"
     "as),sigma,good\n2459000,-7.5,1,T\n2459009.75,2.25,.5,F\n2459025.25,4,2,T\n",
     .first = 2459000, .unit = "uas"},
    {"| t | y | sigma |\n|---|---|---|\n| 2459000 | -7.5 | 1 |\n| 2459009.75 | 2.25 | 0.5 |\n| 2459025.25 | 4 | 2 |\n",
     .first = 2459000},
    {"   t        y   sigma\n---------- ----- ---\n   2459000  -7.5   1\n2459009.75  2.25 0.5\n2459025.25     4   2\n"
     "---------- ----- ---\n",
     .first = 2459000},
    /* JSON */
    {"{\"rv\": -7.5, \"BJD\": 2459000, \"e_rv\": 1}\n{\"rv\": null, \"BJD\": 1, \"e_rv\": 1}\n"
     "{\"rv\": 2.25, \"BJD\": 2459009.75, \"e_rv\": 0.5}\n{\"rv\": 4, \"BJD\": 2459025.25, \"e_rv\": 2}\n",
     .first = kUtc, .warning = "s.csv: 1 of 4 rows have no value and are skipped", .missing = 1, TAI},
    {" [{\"t\": 2459000, \"y\": -7.5, \"sigma\": 1},\n  {\"t\": 2459009.75, \"s\": \"}\\\"\", \"y\": 2.25, \"sigma\": "
     "0.5}\n"
     ", {\"t\": 2459025.25,\n \"y\": 4, \"sigma\": 2}]\n",
     .first = 2459000, .whole_only = 1},
    /* several instruments */
    {"t,y,sigma,tel\n2459000,-7.5,1,1\n2459009.75,2.25,0.5,2\n2459025.25,4,2,1\n", .first = 2459000,
     .warning =
         "s.csv: column tel seems to name several instruments: without the option instrument, the series is read as "
         "that of one"},
};

/* Warnings, one per line. */
static void collect(int32_t level, const char *text, void *data) {
    char *const all = data;
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    assert_true(strlen(all) + strlen(text) < 900);
    strcat(strcat(all, all[0] != '\0' ? "\n" : ""), text);
}

static void assert_numbers(const table *is, const double *t, const double *y, const double *sigma) {
    for (int i = 0; i < N; i++) {
        assert_close(t[i], is->first + kTimes[i], 0, 1e-8);
        assert_close(y[i], kValues[i], 0, 0);
        if (!is->unweighted)
            assert_close(sigma[i], kSigmas[i], 1e-15, 0);
    }
}

static void assert_whole(const table *is) {
    char warnings[1000] = "";
    toliman_measure_options options = TOLIMAN_MEASURE_OPTIONS_INIT;
    toliman_measure *measure = NULL;
    options.columns = is->columns;
    options.log = collect;
    options.log_data = warnings;
    assert_ok(toliman_measure_load(is->text, strlen(is->text), "s.csv", &options, &measure));
    toliman_measure_info info = TOLIMAN_MEASURE_INFO_INIT;
    assert_ok(toliman_measure_get_info(measure, &info));
    assert_int_equal(info.n, N);
    assert_int_equal(info.left_out, is->missing);
    assert_int_equal(info.is_weighted, !is->unweighted);
    assert_string_equal(info.unit_name, is->unit != NULL ? is->unit : "");
    assert_string_equal(warnings, is->warning != NULL ? is->warning : "");
    assert_int_equal(info.time_scale, is->scale);
    double t[N], y[N], sigma[N];
    assert_ok(toliman_measure_get_values(measure, "t", t, N));
    assert_ok(toliman_measure_get_values(measure, "y", y, N));
    if (!is->unweighted)
        assert_ok(toliman_measure_get_values(measure, "sigma", sigma, N));
    assert_numbers(is, t, y, sigma);
    toliman_measure_destroy(measure);
}

static void assert_lines(const table *is) {
    toliman_series_options options = TOLIMAN_SERIES_OPTIONS_INIT;
    toliman_series *series = NULL;
    double t[N], y[N], sigma[N];
    int found = 0;
    options.columns = is->columns;
    assert_ok(toliman_series_create(&options, &series));
    for (const char *line = is->text; *line != '\0';) {
        const size_t length = strcspn(line, "\n") + 1;
        toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
        assert_ok(toliman_series_parse(series, line, length, &sample));
        if (sample.found) {
            assert_true(found < N);
            t[found] = sample.t;
            y[found] = sample.y;
            sigma[found++] = sample.sigma;
        }
        line += length;
    }
    assert_int_equal(found, N);
    assert_numbers(is, t, y, sigma);
    toliman_series_info info = TOLIMAN_SERIES_INFO_INIT;
    assert_ok(toliman_series_get_info(series, &info));
    assert_int_equal(info.missing, is->missing);
    assert_string_equal(info.unit_name, is->unit != NULL ? is->unit : "");
    toliman_series_destroy(series);
}

TEST(tables_are_read) {
    for (size_t i = 0; i < sizeof kTables / sizeof *kTables; i++) {
        print_message("%.60s\n", kTables[i].text); /* of the last one, if it fails */
        assert_whole(&kTables[i]);
        if (!kTables[i].whole_only)
            assert_lines(&kTables[i]);
    }
}

#define GOOD "1,2,1\n2,3,1\n3,2,1\n4,3,1\n5,2,1\n6,3,1\n"

/* promise: missing-marks-are-no-values */
TEST(others_are_refused) {
    const struct {
        const char *text, *columns;
        toliman_status status;
        const char *message;
    } cases[] = {
        /* damage */
        {MRT_HEAD "A  2459000.00 -7.50 100", NULL, TOLIMAN_E_FORMAT, "e_RV"},
        {MRT_HEAD "A  2459000.0\n", NULL, TOLIMAN_E_FORMAT, "BJD"},
        {MRT_HEAD "A  2459000.00 -7.50 1000.0 1\nAxx2459000.00\n", NULL, TOLIMAN_E_FORMAT, "BJD"},
        {MRT_HEAD "A  2459000.00 -7.5x 1000.0 1\n", NULL, TOLIMAN_E_FORMAT, "y"},
        {MRT_HEAD, NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {MRT_HEAD MRT_HEAD, NULL, TOLIMAN_E_FORMAT, "BJD"},
        {MRT_HEAD MRT_ROWS MRT_HEAD MRT_ROWS, NULL, TOLIMAN_E_FORMAT, "BJD"},
        {"|t   |y   |sigma|\n|double|double|double|\n 1    2\n", NULL, TOLIMAN_E_FORMAT, "sigma"},
        {"t,y,sigma\n1,2,1\n1,2\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"t,y,sigma\n1,2,1,4\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"t,y,sigma\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"t,y,sigma\n1,,1\n2,,1\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"t,y,sigma\n1,2,1\nt,y,sigma\n2,3,1\n", NULL, TOLIMAN_E_FORMAT, "t"},
        {"# %ECSV 1.0\nt y\n1 2\n# %ECSV 1.0\nt y\n1 2\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"t,y\n1,2 # x\n2,3x\n", NULL, TOLIMAN_E_FORMAT, "y"},
        {"t;y\n1,5;2\n2.5;3\n", NULL, TOLIMAN_E_FORMAT, "t"},
        {"t;y\n1.5;2\n2,5;3\n", NULL, TOLIMAN_E_FORMAT, "t"},
        {"t,y\n1,inf\n", NULL, TOLIMAN_E_FORMAT, "y"},
        {"t,y,sigma\nd,m/s\n1,2,1\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"[{\"t\": 1, \"y\": 2}, {\"t\": 1}]", NULL, TOLIMAN_E_FORMAT, "y"},
        {"[{\"t\": 1, \"y\": 2} {\"t\": 1, \"y\": 2}]", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"[{\"t\": 1, \"y\": 2},", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"[]", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        /* other formats */
        {"<?xml version=\"1.0\"?>\n<VOTABLE>", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"\xef\xbb\xbf\n <html>\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"\\begin{tabular}{ll}\nt & y \\\\\n1 & 2 \\\\\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"\xff\xfet", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"\x1f\x8b\x08", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"PK\x03\x04", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"t,y\r1,2\r2,3\r", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        /* times */
        {"date,y\n20200101,1\n", NULL, TOLIMAN_E_FORMAT, "date"},
        {"rjd,y\n2459000.5,1\n", NULL, TOLIMAN_E_FORMAT, "t"},
        {"mjd,y\ns,m/s\n1,2\n", NULL, TOLIMAN_E_MISMATCH, "mjd"},
        {"t [m/s],y\n1,2\n", NULL, TOLIMAN_E_MISMATCH, "t [m/s]"},
        /* columns that could be meant */
        {"bjd,rv,vrad\n1,2,3\n", NULL, TOLIMAN_E_MISMATCH, "rv"},
        {"bjd,hjd,rv\n1,2,3\n", NULL, TOLIMAN_E_MISMATCH, "bjd"},
        {"bjd,rv,e_rv,T\n1,2,3,4\n", NULL, TOLIMAN_E_MISMATCH, "bjd"},
        {"bjd,rv,e_rv,rv_err\n1,2,3,4\n", NULL, TOLIMAN_E_MISMATCH, "e_rv"},
        {"bjd,rv,e_rv,sigma\n1,2,3,4\n", NULL, TOLIMAN_E_MISMATCH, "e_rv"},
        {"bjd,fwhm\n1,2\n", NULL, TOLIMAN_E_MISMATCH, "y"},
        {GOOD, "1,4", TOLIMAN_E_MISMATCH, "4"},
        {"t,y\n1,2\n", "1,x", TOLIMAN_E_MISMATCH, "x"},
        /* units that cannot be converted */
        {"t,y (m/s),sigma (mas)\n1,2,1\n", NULL, TOLIMAN_E_MISMATCH, "sigma (mas)"},
        /* numbers that stand for missing values */
        {GOOD "7,-9999,1\n8,-9999,1\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {GOOD "7,99.99,1\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {"0,2,99\n" GOOD, NULL, TOLIMAN_E_FORMAT, "s.csv"},
        {GOOD "7,1e30,1\n", NULL, TOLIMAN_E_FORMAT, "s.csv"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_measure_options options = TOLIMAN_MEASURE_OPTIONS_INIT;
        toliman_measure *measure = NULL;
        options.columns = cases[i].columns;
        print_message("%.60s\n", cases[i].message);
        assert_refused(toliman_measure_load(cases[i].text, strlen(cases[i].text), "s.csv", &options, &measure),
                       cases[i].status, cases[i].message);
    }
}

/* Nines among numbers that reach as far are numbers. */
/* promise: missing-marks-are-no-values */
TEST(nines_may_be_values) {
    static const char text[] = "1,100,1\n2,99.9,1\n3,-80,1\n4,999,99\n5,700,80\n6,500,120\n7,50,70\n8,10,70\n9,9,70\n";
    toliman_measure *measure = NULL;
    assert_ok(toliman_measure_load(text, sizeof text - 1, NULL, NULL, &measure));
    toliman_measure_destroy(measure);
}

/* A unit of the table is that of the measurements, and must not be contradicted. */
TEST(units_give_kinds) {
    const struct {
        const char *unit;
        int32_t kind;
        double option;
        int32_t result; /* kind, or 0 for an error */
        double factor;
    } cases[] = {
        {"km/s", 0, 0, TOLIMAN_MEASURE_VELOCITY, 1000},
        {"km/s", TOLIMAN_MEASURE_VELOCITY, 1000, TOLIMAN_MEASURE_VELOCITY, 1000},
        {"km/s", 0, 1, 0, 0},
        {"km/s", TOLIMAN_MEASURE_SEPARATION, 0, 0, 0},
        {"mas", 0, 0, TOLIMAN_MEASURE_VALUE, 1e-3},
        {"mas", TOLIMAN_MEASURE_SEPARATION, 0, TOLIMAN_MEASURE_SEPARATION, 1e-3},
        {"mas", TOLIMAN_MEASURE_VELOCITY, 0, 0, 0},
        {"px", TOLIMAN_MEASURE_SEPARATION, 0.375, TOLIMAN_MEASURE_SEPARATION, 0.375},
        {"px", TOLIMAN_MEASURE_SEPARATION, 0, 0, 0},
        {"mag", 0, 0, TOLIMAN_MEASURE_VALUE, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[100];
        toliman_measure_options options = TOLIMAN_MEASURE_OPTIONS_INIT;
        toliman_measure *measure = NULL;
        options.kind = cases[i].kind;
        options.unit = cases[i].option;
        snprintf(text, sizeof text, "t [yr],y [%s]\n1,2\n2,3\n", cases[i].unit);
        const toliman_status status = toliman_measure_load(text, strlen(text), NULL, &options, &measure);
        assert_int_equal(status, cases[i].result != 0 ? TOLIMAN_OK : TOLIMAN_E_ARGUMENT);
        if (status != TOLIMAN_OK)
            continue;
        toliman_measure_info info = TOLIMAN_MEASURE_INFO_INIT;
        assert_ok(toliman_measure_get_info(measure, &info));
        assert_int_equal(info.kind, cases[i].result);
        assert_close(info.unit, cases[i].factor, 1e-15, 0);
        assert_close(info.time_unit_days, 365.25, 0, 0);
        assert_string_equal(info.unit_name, cases[i].unit);
        toliman_measure_destroy(measure);
    }
}

TEST(instruments_are_numbered) {
    const char *const lines[] = {"t,y,spectrograph,note\n", "1,2,A,x\n", "2,3,B,x\n", "3,4,,y\n", "4,5,A,x\n"};
    const int64_t expected[] = {-1, 0, 1, -1, 0};
    for (int named = 0; named < 3; named++) {
        toliman_series_options options = TOLIMAN_SERIES_OPTIONS_INIT;
        toliman_series *series = NULL;
        options.instrument = named == 0 ? NULL : named == 1 ? "Spectrograph" : "3";
        assert_ok(toliman_series_create(&options, &series));
        for (int i = 0; i < 5; i++) {
            toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
            assert_ok(toliman_series_parse(series, lines[i], strlen(lines[i]), &sample));
            assert_int_equal(sample.instrument, named != 0 ? expected[i] : -1);
        }
        toliman_series_info info = TOLIMAN_SERIES_INFO_INIT;
        assert_ok(toliman_series_get_info(series, &info));
        assert_int_equal(info.instruments, named != 0 ? 2 : 0);
        assert_string_equal(info.likely_instrument, named != 0 ? "" : "spectrograph");
        toliman_series_destroy(series);
    }
    toliman_series_options options = TOLIMAN_SERIES_OPTIONS_INIT;
    toliman_series *series = NULL;
    toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
    options.instrument = "tel";
    assert_ok(toliman_series_create(&options, &series));
    assert_refused(toliman_series_parse(series, lines[0], strlen(lines[0]), &sample), TOLIMAN_E_MISMATCH, "tel");
    toliman_series_destroy(series);
}

RUN_TESTS(NULL, NULL)
