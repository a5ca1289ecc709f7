/* Follows a pair of files that grows while it is downlinked, and prints the period of its frames.
 *
 *     follow SCENE PAIR FRAMES      until FRAMES frames, one per day, have been read
 */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <toliman/toliman.h>

static void check(toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    fprintf(stderr, "%s\n", toliman_last_error());
    exit(EXIT_FAILURE);
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: follow SCENE PAIR FRAMES\n");
        return EXIT_FAILURE;
    }
    const long frames = atol(argv[3]);
    toliman_sim *sim = NULL;
    toliman_linear *estimator = NULL; /* or a toliman_cae with trained weights */
    toliman_track *tracker = NULL;
    toliman_ingest *pair = NULL;
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    toliman_ingest_options reading = TOLIMAN_INGEST_OPTIONS_INIT;
    check(toliman_sim_create_file(argv[1], NULL, &sim));
    check(toliman_linear_create(sim, NULL, &estimator));
    options.estimator.linear = estimator; /* and a folder, for results that last */
    options.grid.f0 = 1.5 / (double)frames;
    options.grid.df = 0.1 / (double)frames;
    options.grid.nf = 5 * frames;
    check(toliman_track_create(&options, &tracker));
    reading.flags = TOLIMAN_INGEST_GROWING;
    check(toliman_ingest_create(argv[2], &reading, &pair));

    for (long read = 0; read < frames;) {
        toliman_frame frame = TOLIMAN_FRAME_INIT;
        toliman_ingest_event event = TOLIMAN_INGEST_EVENT_INIT;
        toliman_track_outcome outcome = TOLIMAN_TRACK_OUTCOME_INIT;
        size_t done;
        check(toliman_ingest_next(pair, &frame, &event));
        if (event.event == TOLIMAN_INGEST_EVENT_NOTHING) {
            sleep(1);
        } else if (event.event == TOLIMAN_INGEST_EVENT_FRAME) {
            check(toliman_track_push(tracker, &frame, 1, &outcome, &done));
            read++;
        } else {
            fprintf(stderr, "%s:%lld: %s\n", event.file, (long long)event.line, event.text);
        }
    }
    toliman_period_peak fit = TOLIMAN_PERIOD_PEAK_INIT;
    check(toliman_track_query_fit(tracker, &fit));
    printf("period %.3f +- %.3f days\n", fit.period, fit.period_error);
    return EXIT_SUCCESS;
}
