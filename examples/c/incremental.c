/* A ground station that receives frames late, duplicated and out of order, and queries the period after each of them.
 *
 *     incremental SCENE FOLDER FIRST END      one downlink pass with frames FIRST to END - 1
 *
 * The folder stores the tracker's state: the next pass resumes where the last one stopped.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <toliman/toliman.h>

static void check(toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    fprintf(stderr, "%s: %s\n", toliman_constant_name(status), toliman_last_error());
    exit(EXIT_FAILURE);
}

/* Calls on_frame for every frame received. This stand-in for your reader simulates a bad downlink: groups of eight
 * frames arrive in reverse order, every fifth frame is duplicated, and every fiftieth arrives at the end of the pass.
 */
static void read_downlink(const toliman_sim *sim, long first, long end,
                          void (*on_frame)(const toliman_frame *frame, void *user_data), void *user_data) {
    static double pixels[256 * 256];
    toliman_frame frame = {sizeof frame, TOLIMAN_PIXEL_F64, "sky", "core", .pixels = pixels, .rows = 256, .cols = 256};
    for (int late = 0; late < 2; late++)
        for (long i = first - first % 8; i < end + 8; i++) {
            const long k = i ^ 7;
            if (k < first || k >= end || (k % 50 == 20) != late)
                continue;
            double days;
            check(toliman_sim_get_series(sim, k, 1, &days, NULL));
            check(toliman_sim_frame(sim, NULL, 1, k, 1, pixels));
            frame.frame_id = k;
            frame.camera_ns = llround(days * 86400e9);
            for (int copies = k % 5 == 0 ? 2 : 1; copies > 0; copies--)
                on_frame(&frame, user_data);
        }
}

struct host {
    toliman_track *tracker;
    const toliman_period *period; /* the tracker's periodogram, updated by every push */
    double answer;                /* last printed period, days */
};

static long long frames_in(const toliman_period *period) {
    toliman_period_info info = TOLIMAN_PERIOD_INFO_INIT;
    check(toliman_period_get_info(period, &info));
    return info.count;
}

/* Pushes a frame and queries the period. Repeated interim queries need the sequential false alarm probability. Below
 * 1e-3 the period is significant; it is printed whenever it has changed by 5 %. */
static void on_frame(const toliman_frame *frame, void *user_data) {
    struct host *host = user_data;
    toliman_track_outcome outcome = TOLIMAN_TRACK_OUTCOME_INIT;
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    size_t done;
    double log10_fap;
    check(toliman_track_push(host->tracker, frame, 1, &outcome, &done));
    if (outcome.verdict != TOLIMAN_TRACK_VERDICT_ACCEPTED || frames_in(host->period) < 5)
        return; /* a duplicate, for example; see outcome.verdict */
    check(toliman_period_query_peak(host->period, &peak));
    check(toliman_period_query_fap(host->period, TOLIMAN_PERIOD_FAP_SEQUENTIAL, peak.log10_residual, &log10_fap));
    if (log10_fap > -3 || fabs(peak.period - host->answer) < 0.05 * peak.period)
        return;
    host->answer = peak.period;
    printf("frame %lld: period %.1f days, log10 FAP %.1f\n", (long long)frame->frame_id, peak.period, log10_fap);
}

int main(int argc, char **argv) {
    if (argc != 5) {
        fprintf(stderr, "usage: incremental SCENE FOLDER FIRST END\n");
        return EXIT_FAILURE;
    }
    toliman_sim *sim = NULL;
    toliman_linear *estimator = NULL; /* or a toliman_cae with trained weights */
    struct host host = {0};
    check(toliman_sim_create_file(argv[1], NULL, &sim));
    check(toliman_linear_create(sim, NULL, &estimator));
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.folder = argv[2];
    options.estimator.linear = estimator;
    options.grid.f0 = 1.5 / 1095; /* cycles per day, for 1095 days with one frame per day */
    options.grid.df = 0.1 / 1095;
    options.grid.nf = 5461;
    check(toliman_track_create(&options, &host.tracker));
    check(toliman_track_get_period(host.tracker, &host.period));
    printf("%lld frames tracked so far\n", frames_in(host.period));

    read_downlink(sim, atol(argv[3]), atol(argv[4]), on_frame, &host);

    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    check(toliman_track_save(host.tracker));
    check(toliman_track_query_fit(host.tracker, &peak));
    printf("period %.2f +- %.2f days of %lld frames\n", peak.period, peak.period_error, frames_in(host.period));
    toliman_track_destroy(host.tracker);
    toliman_linear_destroy(estimator);
    toliman_sim_destroy(sim);
    return EXIT_SUCCESS;
}
