// Method: a frame is good if all pixels have a value, it has not over twice as many rows of zeros as most, its light is
// from half to twice the median, and no earlier frame has the same pixels and time. Of the good frames of a window, the
// first in time is chosen, then again and again the one that is farthest from all chosen ones, in time and pointing,
// each over its span (at least 1 px): parameters are told apart by other dates and other places of the stars. T. F.
// Gonzalez, Theor. Comput. Sci. 38, 293 (1985): the largest distance to a chosen one is at most twice the least
// possible.
#include "frames/frame_set.hpp"

#include <set>
#include <tuple>

#include "common/median.hpp"
#include "common/warnings.hpp"
#include "frames/predictions.hpp"
#include "scenes/exposures.hpp"

namespace cli {

namespace {

constexpr double kLeastLight = 0.5, kMostLight = 2; // of the median
constexpr double kLeastSpan = 1;                    // px
constexpr size_t kFewRows = 2;                      // of zeros, which a frame without bias may have

// A frame of a file.
struct Candidate {
    size_t file, frame;
    toliman_fit_prediction prediction;
    std::optional<FrameWindow> window;
    std::string fault;      // empty: a good frame
    bool is_repeat = false; // of an earlier one: counted
    size_t dark_rows = 0;
    double light = 0, x = 0, y = 0; // counts above the median pixel, and their barycentre, px
    bool chosen = false;
};

// [rows][cols]
void survey(const std::vector<double> &image, size_t cols, Candidate &frame) {
    std::vector<double> sorted = image;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    double x = 0, y = 0;
    for (size_t first = 0; first < image.size(); first += cols) {
        bool dark = true;
        for (size_t i = first; i < first + cols; i++) {
            const double light = std::max(0.0, image[i] - *middle);
            frame.light += light;
            x += light * static_cast<double>(i - first);
            y += light * static_cast<double>(first / cols);
            dark &= image[i] == 0;
        }
        frame.dark_rows += dark;
    }
    frame.x = x / frame.light;
    frame.y = y / frame.light;
    if (!(frame.light > 0))
        frame.fault = "no light";
}

// Of a sum, per frame.
double light_of(const Candidate &frame) {
    const toliman_spread *const spread = frame.prediction.spread;
    return spread == nullptr ? frame.light : frame.light / std::max(1.0, spread->frames);
}

std::vector<Candidate *> good_of(std::vector<Candidate> &frames) {
    std::vector<Candidate *> good;
    for (Candidate &frame : frames)
        if (frame.fault.empty() && !frame.is_repeat)
            good.push_back(&frame);
    return good;
}

void judge(std::vector<Candidate> &frames) {
    const std::vector<Candidate *> read = good_of(frames);
    std::vector<double> lights;
    std::vector<size_t> dark_rows;
    for (const Candidate *frame : read) {
        lights.push_back(light_of(*frame));
        dark_rows.push_back(frame->dark_rows);
    }
    const double light = median(lights);
    const size_t dark = median(dark_rows);
    std::set<std::tuple<double, double, double, double>> known;
    for (Candidate *frame : read) {
        const double ratio = light_of(*frame) / light;
        if (frame->dark_rows > 2 * dark + kFewRows)
            frame->fault = std::to_string(frame->dark_rows) + " rows of zeros: a part is missing";
        else if (!(ratio >= kLeastLight && ratio <= kMostLight))
            frame->fault = formatted("%.3g times the light of the others", ratio);
        else if (!known.insert({frame->prediction.time_days, frame->light, frame->x, frame->y}).second)
            frame->is_repeat = true;
    }
}

using Span = std::pair<double, double>; // least and largest value

Span span_of(const std::vector<Candidate *> &frames, double (*value)(const Candidate &)) {
    Span span = {INFINITY, -INFINITY};
    for (const Candidate *frame : frames)
        span = {std::min(span.first, value(*frame)), std::max(span.second, value(*frame))};
    return span;
}

constexpr double (*kAxes[])(const Candidate &) = {[](const Candidate &frame) { return frame.prediction.time_days; },
                                                  [](const Candidate &frame) { return frame.x; },
                                                  [](const Candidate &frame) { return frame.y; }};

double length_of(const std::vector<Candidate *> &frames, size_t axis) {
    const auto [least, largest] = span_of(frames, kAxes[axis]);
    return largest - least;
}

void choose(const std::vector<Candidate *> &frames, size_t most) {
    double scale[3];
    for (size_t axis = 0; axis < 3; axis++) {
        const double length = length_of(frames, axis), span = axis == 0 ? length : std::max(length, kLeastSpan);
        scale[axis] = span > 0 ? 1 / span : 0;
    }
    std::vector<double> distance(frames.size(), INFINITY);
    const auto earlier = [](const Candidate *a, const Candidate *b) {
        return a->prediction.time_days < b->prediction.time_days;
    };
    auto next = static_cast<size_t>(std::min_element(frames.begin(), frames.end(), earlier) - frames.begin());
    for (size_t count = 0; count < std::min(most, frames.size()); count++) {
        frames[next]->chosen = true;
        distance[next] = -1;
        for (size_t i = 0; i < frames.size(); i++) {
            double square = 0;
            for (size_t axis = 0; axis < 3; axis++) {
                const double step = scale[axis] * (kAxes[axis](*frames[i]) - kAxes[axis](*frames[next]));
                square += step * step;
            }
            distance[i] = std::min(distance[i], square);
        }
        next = static_cast<size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    }
}

void choose_in_windows(const std::vector<Candidate *> &good, const FrameChoice &choice) {
    const double first = span_of(good, kAxes[0]).first;
    std::map<double, std::vector<Candidate *>> windows;
    for (Candidate *frame : good)
        windows[choice.window_days > 0 ? std::floor((frame->prediction.time_days - first) / choice.window_days) : 0]
            .push_back(frame);
    for (const auto &[number, frames] : windows)
        choose(frames, choice.most);
}

// Opens the files one after the other. Standard input is read once: its frames are kept.
class Reader {
  public:
    Reader(const FrameOptions &options, const Scene &scene)
        : options_(options), scene_(scene), paths_(options.inputs()) {}

    const std::vector<std::string> &paths() const { return paths_; }
    std::unique_ptr<FrameFile> open(size_t file) const {
        return options_.open(paths_[file], scene_defaults(scene_.path).exposure_s);
    }
    void survey(Predictions &times, std::deque<toliman_spread> &spreads, std::vector<Candidate> &frames,
                Progress &progress);
    // Reads the chosen frames, in their order, to the end of `pixels`.
    void read(const std::vector<Candidate *> &chosen, std::vector<double> &pixels) const;

  private:
    const FrameOptions &options_;
    const Scene &scene_;
    std::vector<std::string> paths_;
    std::map<size_t, std::vector<double>> kept_; // by number of the frame
};

void Reader::survey(Predictions &times, std::deque<toliman_spread> &spreads, std::vector<Candidate> &frames,
                    Progress &progress) {
    const auto cols = static_cast<size_t>(scene_.info.cols);
    std::vector<double> image(scene_.pixels());
    const SceneExposures exposures(scene_defaults(scene_.path));
    for (size_t k = 0; k < paths_.size(); k++) {
        const auto file = open(k);
        for (const std::string &note : file->notes())
            progress.warn(note);
        if (file->rows() != static_cast<size_t>(scene_.info.rows) || file->cols() != cols)
            malformed(file->path(), "frames of " + shape_text(file->rows(), file->cols()) + ": the scene is for " +
                                        shape_text(scene_.info.rows, scene_.info.cols));
        times.open(*file);
        for (size_t i = 0; file->more(); i++) {
            Candidate frame = {k, i, *times.from(i, 1), file->window(i), ""};
            if (frame.prediction.spread != nullptr)
                frame.prediction.spread = &spreads.emplace_back(*frame.prediction.spread);
            const auto blank = file->read_values(image.data());
            if (const auto tai_ns = times.tai_ns(0); tai_ns && exposures.at(*tai_ns).empty())
                frame.fault = "no time on target";
            else if (blank)
                frame.fault = blank_text(*blank, cols);
            else
                cli::survey(image, cols, frame);
            if (paths_[k] == "-")
                kept_[i] = image;
            frames.push_back(std::move(frame));
            progress.note("read", std::to_string(frames.size()) + " frames");
            stop_if_asked();
        }
    }
}

void Reader::read(const std::vector<Candidate *> &chosen, std::vector<double> &pixels) const {
    std::unique_ptr<FrameFile> opened;
    size_t file = SIZE_MAX, at = 0; // number of the file that is open, and of its next frame
    for (const Candidate *frame : chosen) {
        if (paths_[frame->file] == "-") {
            const std::vector<double> &image = kept_.at(frame->frame);
            pixels.insert(pixels.end(), image.begin(), image.end());
            continue;
        }
        if (std::exchange(file, frame->file) != frame->file) {
            opened = open(file);
            at = 0;
        }
        for (; at < frame->frame; at++)
            opened->skip();
        pixels.resize(pixels.size() + scene_.pixels());
        opened->read_finite(&pixels[pixels.size() - scene_.pixels()]);
        at++;
    }
}

// "night1.fits: frame 3: no light"
std::vector<std::string> faults_of(const std::vector<Candidate> &frames, const std::vector<std::string> &paths) {
    std::vector<std::string> faults;
    for (const Candidate &frame : frames)
        if (!frame.fault.empty())
            faults.push_back(paths[frame.file] + ": frame " + std::to_string(frame.frame) + ": " + frame.fault);
    return faults;
}

} // namespace

FrameSet::FrameSet(const FrameOptions &options, const Scene &scene, const FrameChoice &choice, Progress &progress) {
    const Cadence cadence(scene);
    const std::optional<int64_t> time_zero = if_known(scene.info.time_zero_ns != 0, scene.info.time_zero_ns);
    Predictions times(cadence.times, 1, {options.cadence, time_zero, LeapSeconds()}, progress);
    Reader reader(options, scene);
    std::vector<Candidate> frames;
    reader.survey(times, spreads_, frames, progress);
    judge(frames);
    const std::vector<Candidate *> good = good_of(frames);
    const std::vector<std::string> faults = faults_of(frames, reader.paths());
    if (good.size() < 2)
        throw Failure(kExitInput, (faults.empty() ? reader.paths()[0] : faults[0]) + ": " +
                                      std::to_string(good.size()) + " good frames of " + std::to_string(frames.size()) +
                                      ": a calibration needs at least 2, and about 10 for accurate optics");
    Warnings warnings(progress);
    for (const std::string &fault : faults)
        warnings.warn("left out", fault + ": left out", kMostInputs);
    warnings.end([&](const std::string &kind, int64_t count, int64_t) {
        return formatted("%lld of %zu frames ", static_cast<long long>(count), frames.size()) + kind;
    });
    choose_in_windows(good, choice);
    std::vector<Candidate *> chosen;
    std::copy_if(good.begin(), good.end(), std::back_inserter(chosen),
                 [](const Candidate *one) { return one->chosen; });
    reader.read(chosen, pixels);
    for (const Candidate *frame : chosen) {
        places.push_back({reader.paths()[frame->file], frame->frame});
        predictions.push_back(frame->prediction);
        if (frame->window && windows.size() + 1 == places.size())
            windows.push_back(*frame->window);
    }
    if (windows.size() < places.size())
        windows.clear();
    const auto repeats =
        std::count_if(frames.begin(), frames.end(), [](const Candidate &one) { return one.is_repeat; });
    if (repeats > 0)
        progress.tell(formatted("%td of %zu frames repeat an earlier one", repeats, frames.size()));
    if (chosen.size() < frames.size())
        progress.tell(formatted("calibrates with %zu of %zu frames, spread over %.3g days and %.2f x %.2f px",
                                chosen.size(), frames.size(), length_of(chosen, 0), length_of(chosen, 1),
                                length_of(chosen, 2)));
}

std::string FrameSet::name(size_t i) const {
    return places[i].file + ": frame " + std::to_string(places[i].frame);
}

} // namespace cli
