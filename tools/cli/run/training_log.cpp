// Method: the loss cannot show whether a network has learned the signal: the image and its noise dominate it. Every ten
// epochs three series of frames are therefore encoded, and their period is searched: the frames of the training, those
// of `toliman simulate`, which have other noise, and frames without signal. A network that fits the noise of its
// training frames finds a period in the first series alone; one that has learned the signal finds it in the second too;
// the third shows how small a false alarm probability becomes by chance.
#include "run/training_log.hpp"

#include <cstdlib>
#include <filesystem>

#include "common/content.hpp"
#include "frames/frame_loop.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

constexpr char kColumns[] = "epoch,loss,validation_loss,mmse,mssim,log10_fap_trained,log10_fap_fresh,log10_fap_none\n";
constexpr uint32_t kEvery = 10; // epochs between two searches

// The lines of an earlier log up to an epoch.
std::vector<std::string> earlier_lines(const std::string &path, uint32_t epochs) {
    std::vector<std::string> lines;
    const std::string text = whole_text(path), head = std::string(kEpochsMark) + kColumns;
    if (text.compare(0, head.size(), head) != 0)
        malformed(path, "is not the log of an unsupervised training");
    for (size_t start = head.size(), end; (end = text.find('\n', start)) != std::string::npos; start = end + 1) {
        const std::string line = text.substr(start, end + 1 - start);
        if (std::strtoul(line.c_str(), nullptr, 10) <= epochs)
            lines.push_back(line);
    }
    return lines;
}

} // namespace

TrainingLog::TrainingLog(const std::string &path, const Scene &scene, uint64_t training_seed, uint32_t epochs)
    : path_(path), scene_(scene), cadence_(scene), training_seed_(training_seed) {
    check_cadence(scene, "--log");
    if (epochs > 0 && std::filesystem::exists(path))
        lines_ = earlier_lines(path, epochs);
    check_output(path);
}

void TrainingLog::add_untrained(const toliman_cae *network) {
    lines_.push_back("0,,,," + faps_of(network));
    write();
}

bool TrainingLog::add(const toliman_cae *network, const toliman_cae_training &result, bool last) {
    const std::string line = formatted("%u,%.6g,%.6g,%.6g,%.9f", result.epochs, result.loss, result.validation_loss,
                                       result.mmse, result.mssim);
    const bool searched = last || result.epochs % kEvery == 0;
    lines_.push_back(line + (searched ? faps_of(network) : ",,,\n"));
    write();
    return searched;
}

// Of frames of the training, of fresh frames, and of frames without signal.
std::string TrainingLog::faps_of(const toliman_cae *network) const {
    const std::vector<double> still(cadence_.times.size());
    return formatted(",%.2f,%.2f,%.2f\n", log10_fap(network, training_seed_, nullptr),
                     log10_fap(network, scene_.info.seed, nullptr),
                     log10_fap(network, scene_.info.seed + 1, still.data()));
}

// Of the frames of the cadence with the noise of this seed.
double TrainingLog::log10_fap(const toliman_cae *network, uint64_t seed, const double *displacements) const {
    Progress quiet(Progress::Style::none);
    std::vector<double> values(cadence_.times.size());
    for_frames(scene_, seed, 0, values.size(), displacements, [&](size_t at, size_t count, double *images) {
        const toliman_image image = plain_image(images);
        toliman::check(toliman_cae_encode(network, &image, count, &values[at], nullptr));
    });
    const toliman::measurements series = series_of(scene_.path, cadence_.times, values);
    return find_period(series.get(), default_grid(scene_.path, cadence_.times), {}, quiet).peak.log10_fap;
}

void TrainingLog::write() const {
    OutputFile file(path_);
    file.write(std::string(kEpochsMark) + kColumns);
    for (const std::string &line : lines_)
        file.write(line);
    file.commit();
}

} // namespace cli
