/* Fits the forward model to frames of stars that follow their orbit, and finds the period of the signal. */
#include <stdio.h>

#include <toliman/fit.h>
#include <toliman/period.h>

enum { FRAMES = 100, PIXELS = 64 * 64 };

/* Each frame is expected where the orbit is at its time; the value is what differs from that. */
static int fit_frames(const toliman_sim *sim, const toliman_fit *fit, toliman_period *period) {
    static double frames[FRAMES * PIXELS];
    double times[FRAMES];
    toliman_fit_prediction predictions[FRAMES] = {TOLIMAN_FIT_PREDICTION_INIT};
    toliman_fit_result results[FRAMES] = {TOLIMAN_FIT_RESULT_INIT};
    const toliman_image image = {.struct_size = sizeof image, .pixels = frames};
    int status = toliman_sim_get_series(sim, 0, FRAMES, times, NULL);
    if (status == TOLIMAN_OK)
        status = toliman_sim_frame(sim, NULL, 1, 0, FRAMES, frames);
    for (int i = 0; i < FRAMES; i++)
        predictions[i].time_days = times[i];
    if (status == TOLIMAN_OK)
        status = toliman_fit_frame(fit, &image, FRAMES, predictions, results, NULL, NULL);
    for (int i = 0; status == TOLIMAN_OK && i < FRAMES; i++)
        if ((results[i].flags & TOLIMAN_FIT_NOT_CONVERGED) == 0)
            status = toliman_period_push(period, times[i], results[i].displacement_px, results[i].separation_sigma_px);
    if (status == TOLIMAN_OK)
        printf("separation %.3f px at first, %.3f px at the end\n", results[0].separation_px,
               results[FRAMES - 1].separation_px);
    return status == TOLIMAN_OK;
}

int main(int count, char **arguments) {
    toliman_sim *sim = NULL;
    toliman_fit *fit = NULL;
    toliman_period *period = NULL;
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    options.sigma_floor = 2e-5;
    const char *const scene = count > 1 ? arguments[1] : "examples/data/moving.json";
    const int found = toliman_sim_create_file(scene, NULL, &sim) == TOLIMAN_OK &&
                      toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit) == TOLIMAN_OK &&
                      toliman_period_create(0.01, 0.001, 200, &options, &period) == TOLIMAN_OK &&
                      fit_frames(sim, fit, period) && toliman_period_query_peak(period, &peak) == TOLIMAN_OK;
    if (found)
        printf("period %.2f days\n", peak.period);
    else
        fprintf(stderr, "%s\n", toliman_last_error());
    toliman_period_destroy(period);
    toliman_fit_destroy(fit);
    toliman_sim_destroy(sim);
    return !found;
}
