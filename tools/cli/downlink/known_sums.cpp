#include "downlink/known_sums.hpp"

#include <fstream>

#include "frames/frames_in.hpp"

namespace cli {

namespace {

// The spread of a line of a side file, without cumulants; nothing for a single frame and a damaged line.
std::optional<toliman_spread> spread_of(const std::string &line) {
    const JsonTree tree(cJSON_Parse(line.c_str()));
    const cJSON *const frames = cJSON_GetObjectItemCaseSensitive(tree.get(), "frames"),
                       *const jitter = cJSON_GetObjectItemCaseSensitive(tree.get(), "jitter_px2");
    if (cJSON_IsNumber(frames) == 0 || cJSON_GetArraySize(jitter) != 3)
        return std::nullopt;
    auto spread = toliman::sized<toliman_spread>();
    spread.frames = frames->valuedouble;
    spread.xx_px2 = cJSON_GetArrayItem(jitter, 0)->valuedouble;
    spread.yy_px2 = cJSON_GetArrayItem(jitter, 1)->valuedouble;
    spread.xy_px2 = cJSON_GetArrayItem(jitter, 2)->valuedouble;
    return spread;
}

} // namespace

KnownSums::KnownSums(const std::vector<std::string> &inputs) {
    for (const std::string &input : inputs) {
        const std::vector<std::string> files = is_folder(input) ? files_of(input) : std::vector<std::string>{input};
        for (const std::string &file : files) {
            if (!is_pair(file)) {
                waits = false;
                continue;
            }
            std::ifstream lines(side_of(file));
            for (std::string line; std::getline(lines, line) && !lines.eof();) { // the last one may be cut
                if (line.find_first_not_of(" \r\t") == std::string::npos)
                    continue;
                waits = false;
                const std::optional<toliman_spread> spread = spread_of(line);
                if (!spread)
                    break;
                if (!largest || largest->frames < spread->frames)
                    largest = spread;
            }
        }
    }
}

double sigma_of(const toliman_fit *fit, const toliman_spread &spread) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.spread = &spread;
    double covariance[TOLIMAN_FIT_MAX_PARAMETERS * TOLIMAN_FIT_MAX_PARAMETERS];
    toliman::check(toliman_fit_predict(fit, &prediction, nullptr, 0, nullptr, covariance));
    return std::sqrt(covariance[0]);
}

} // namespace cli
