#include "frames/frames_out.hpp"

#include "common/npy.hpp"
#include "frames/frames_in.hpp"
#include "scenes/exposures.hpp"

namespace cli {

namespace {

class NpyOutput : public FrameOutput {
  public:
    NpyOutput(const std::string &path, const std::vector<size_t> &axes)
        : out_(path), pixels_(axes.back() * axes[axes.size() - 2]) {
        write_npy_header(out_, axes);
        out_.need_space(axes, sizeof(double));
    }
    void write(const double *images, size_t count) override { out_.write(images, count * pixels_ * sizeof *images); }
    void commit() override { out_.commit(); }

  private:
    OutputFile out_;
    size_t pixels_;
};

// Headerless little-endian counts.
class CountOutput : public FrameOutput {
  public:
    CountOutput(const std::string &path, const CountFormat &format, const Simulated &frames)
        : path_(path), out_(path), format_(format), rows_(frames.rows()), cols_(frames.cols()),
          next_(frames.range.first), largest_(std::ldexp(1.0, format.bit_depth) - 1) {
        out_.need_space({frames.count(), rows_, cols_}, format.wide ? 4 : 2);
    }

    void write(const double *images, size_t count) override {
        for (size_t k = 0; k < count; k++, next_++) {
            if (format_.wide)
                write_frame<uint32_t>(images + k * rows_ * cols_);
            else
                write_frame<uint16_t>(images + k * rows_ * cols_);
        }
    }

    void commit() override { out_.commit(); }

  private:
    template <class T> void write_frame(const double *image) {
        std::vector<T> counts(rows_ * cols_);
        for (size_t i = 0; i < counts.size(); i++) {
            const double rounded = std::nearbyint(image[i]);
            if (rounded < 0) // clipping at 0 would bias the flux
                refuse(i, rounded, "must not be negative in an unsigned file; with noise.read_e write .npy or .fits");
            if (rounded > largest_)
                refuse(i, rounded,
                       "bit depth overflow: must be in [0, " + std::to_string(static_cast<uint64_t>(largest_)) +
                           "] for bit depth " + std::to_string(format_.bit_depth));
            counts[i] = static_cast<T>(rounded);
        }
        out_.write(counts.data(), counts.size() * sizeof counts[0]);
    }

    [[noreturn]] void refuse(size_t pixel, double counts, const std::string &why) const {
        throw Failure(kExitUsage, path_ +
                                      formatted(": frame %lld, row %zu, column %zu: %.0f counts: ",
                                                static_cast<long long>(next_), pixel / cols_, pixel % cols_, counts) +
                                      why);
    }

    std::string path_;
    OutputFile out_;
    CountFormat format_;
    size_t rows_, cols_;
    int64_t next_; // number of the next frame
    double largest_;
};

constexpr size_t kMostIntervals = 64; // of a line that toliman/ingest.h reads

struct ExposureTimes {
    int64_t start_ns, middle_ns;
};

// Of the frame `days` after time 0.
ExposureTimes exposure_at(double days, const toliman_sim_info &scene) {
    const std::optional<int64_t> middle = frame_time(days, scene.time_zero_ns);
    int64_t start = 0;
    if (!middle || __builtin_sub_overflow(*middle, std::llround(scene.exposure_s * 5e8), &start))
        throw Failure(kExitUsage,
                      "timestamp_ns: a frame at " + std::to_string(days) + " days: must be within 100000 days");
    return {start, *middle};
}

// The member of a line for the intervals of an exposure, in s from its start; "" for a scene without.
std::string on_target_member(const SceneExposures &exposures, const ExposureTimes &exposure, const std::string &scene) {
    if (!exposures.has_intervals())
        return "";
    const std::vector<int64_t> times = exposures.at(exposure.middle_ns);
    if (times.empty())
        throw Failure(kExitUsage, scene + ": no window of cadence.on_target is in the exposure that begins at " +
                                      std::to_string(exposure.start_ns) + " ns: --session needs some time on target");
    if (times.size() > 2 * kMostIntervals)
        throw Failure(kExitUsage, scene + ": cadence has " + std::to_string(times.size() / 2) +
                                      " on-target intervals in an exposure: must be at most " +
                                      std::to_string(kMostIntervals) + " for --session");
    std::vector<double> seconds;
    for (const int64_t time : times)
        seconds.push_back(static_cast<double>(time - exposure.start_ns) / 1e9);
    const std::string object = Json("on_target_s", seconds).line(); // and a newline
    return ", " + object.substr(1, object.size() - 3);
}

// The mission's pair of files: counts, and one JSON object per frame. Files of a pair are never replaced.
class SessionOutput : public FrameOutput {
  public:
    SessionOutput(const std::string &folder, const std::string &session, const CountFormat &format,
                  const Simulated &frames)
        : scene_path_(frames.scene.path), exposures_(scene_defaults(scene_path_)), folder_(folder), session_(session),
          dtype_(format.dtype()), cadence_(frames.scene), scene_(frames.scene.info), next_(frames.range.first),
          rows_(frames.rows()), cols_(frames.cols()),
          counts_(count_output(folder_.file(session + "_frames.bin"), format, frames)),
          meta_(folder_.file(session + "_meta.jsonl")) {}

    void write(const double *images, size_t count) override {
        counts_->write(images, count);
        for (size_t k = 0; k < count; k++, next_++) {
            const ExposureTimes exposure = exposure_at(cadence_.times[static_cast<size_t>(next_)], scene_);
            const int64_t start_ns = exposure.start_ns;
            meta_.write("{" +
                        side_members({next_, start_ns, static_cast<double>(start_ns) / 1e9, 0}, kOnlyRegion, rows_,
                                     cols_, session_, dtype_) +
                        on_target_member(exposures_, exposure, scene_path_) + "}\n");
        }
    }

    // The side file last: it implies that the frames are complete.
    void commit() override {
        meta_.finish();
        counts_->commit();
        meta_.commit();
        folder_.keep();
    }

  private:
    std::string scene_path_;
    SceneExposures exposures_;
    OutputFolder folder_;
    std::string session_;
    const char *dtype_;
    Cadence cadence_; // middle of each exposure
    toliman_sim_info scene_;
    int64_t next_; // number of the next frame
    size_t rows_, cols_;
    std::unique_ptr<FrameOutput> counts_;
    OutputFile meta_;
};

} // namespace

std::optional<int64_t> frame_time(double days, int64_t time_zero_ns) {
    const std::optional<int64_t> ns = ns_of_days(days);
    int64_t time = 0;
    return ns && !__builtin_add_overflow(*ns, time_zero_ns, &time) ? std::optional(time) : std::nullopt;
}

std::string free_path(const std::string &path) {
    if (exists(path))
        throw Failure(kExitOutput, path + ": exists already: give another --session, or remove it first");
    return path;
}

std::string side_members(const SideLine &line, const std::string &roi, size_t rows, size_t cols,
                         const std::string &session, const char *dtype) {
    return formatted(
        "\"frame_id\": %lld, \"timestamp_ns\": %lld, \"host_time\": %.9f, \"nframes_dropped\": %lld, "
        "\"roi_label\": \"%s\", \"n_rows\": %zu, \"n_cols\": %zu, \"session_id\": \"%s\", \"dtype\": \"%s\"",
        static_cast<long long>(line.frame_id), static_cast<long long>(line.stamp_ns), line.host_s,
        static_cast<long long>(line.dropped), roi.c_str(), rows, cols, session.c_str(), dtype);
}

std::unique_ptr<FrameOutput> image_output(const std::string &path, const std::vector<size_t> &axes,
                                          const Scene *scene) {
    if (ends_with(path, ".fits"))
        return fits_output(path, axes, scene);
    return std::make_unique<NpyOutput>(path, axes);
}

std::unique_ptr<FrameOutput> count_output(const std::string &path, const CountFormat &format, const Simulated &frames) {
    return std::make_unique<CountOutput>(path, format, frames);
}

std::unique_ptr<FrameOutput> session_output(const std::string &folder, const std::string &session,
                                            const CountFormat &format, const Simulated &frames) {
    for (const char *end : {"_frames.bin", "_meta.jsonl"})
        free_path(plain(folder) + "/" + session + end);
    return std::make_unique<SessionOutput>(folder, session, format, frames);
}

} // namespace cli
