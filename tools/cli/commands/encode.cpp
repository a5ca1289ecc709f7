// toliman encode: values from frames.
#include <exception>

#include "common/warnings.hpp"
#include "frames/encoder.hpp"
#include "frames/frame_options.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct EncodeOptions {
    EstimatorOptions estimator_options;
    FrameReductionOptions reduction;
    FrameOptions frames;
};

// The number of frames in the file if its pixels had the other width: a likely mistake where latents are far off.
std::string other_width(const EncodeOptions &options, const FrameFile &frames) {
    const std::string &dtype = options.frames.dtype;
    const bool wide = dtype.substr(0, 3) == "u32";
    if (dtype.empty() || dtype[0] != 'u' || !frames.counted() || (!wide && frames.count() % 2 != 0))
        return "";
    return " With --dtype " + std::string(wide ? "u16" : "u32") + dtype.substr(3) + " the file has " +
           std::to_string(wide ? frames.count() * 2 : frames.count() / 2) + " frames, with " + dtype + " " +
           std::to_string(frames.count()) + ".";
}

// Frames read at once: encoded on all processors, printed in order. Those of a pipe are printed as they arrive.
class Batch {
  public:
    static constexpr size_t kMost = 64, kMostBytes = size_t{64} << 20;

    Batch(FrameFile &frames, bool is_pipe)
        : frames_(frames), pitch_((frames.frame_size() + sizeof(double) - 1) / sizeof(double)) {
        most_ = is_pipe ? 1 : std::min(kMost, std::max<size_t>(1, kMostBytes / frames.frame_size()));
        most_ = std::min(most_, frames.count());
        pixels_.resize(most_ * pitch_);
        windows_.resize(most_);
    }

    // Reads the next frames. An error waits until those before it are printed.
    void read() {
        first_ += count_;
        count_ = 0;
        try {
            while (count_ < most_ && frames_.more()) {
                frames_.read(&pixels_[count_ * pitch_]);
                const std::optional<FrameWindow> window = frames_.window(first_ + count_);
                placed_ = window.has_value();
                windows_[count_++] = window.value_or(FrameWindow());
            }
        } catch (...) {
            if (count_ == 0)
                throw;
            failure_ = std::current_exception();
        }
    }
    void rethrow() const {
        if (failure_)
            std::rethrow_exception(failure_);
    }

    // The frames that were read, from number i on.
    toliman_image image(size_t i) const {
        const size_t pixels = frames_.rows() * frames_.cols(), width = frames_.frame_size() / pixels;
        auto image = toliman::sized<toliman_image>();
        image.pixel = frames_.pixel();
        image.pixels = &pixels_[i * pitch_];
        image.frame_stride = static_cast<int64_t>(pitch_ * sizeof(double) / width);
        image.windows = placed_ ? windows_[i].data() : nullptr;
        return image;
    }
    size_t first() const noexcept { return first_; }
    size_t count() const noexcept { return count_; }

  private:
    FrameFile &frames_;
    size_t pitch_; // from frame to frame, in doubles: each is aligned for every type
    size_t most_, first_ = 0, count_ = 0;
    std::vector<double> pixels_;
    bool placed_ = false; // the file tells the windows
    std::vector<FrameWindow> windows_;
    std::exception_ptr failure_;
};

FrameReductionOptions with_scene(FrameReductionOptions options, const Estimator &estimator, Notes &notes) {
    options.use_scene(estimator, notes);
    return options;
}

class Encoding {
  public:
    Encoding(const EncodeOptions &options, Progress &progress)
        : options_(options), progress_(progress), estimator_(options.estimator_options, progress),
          reduction_options_(with_scene(options.reduction, estimator_, notes_)),
          encoder_(make_encoder(estimator_, Batch::kMost,
                                {options.frames.cadence, reduction_options_.time_zero_ns,
                                 LeapSeconds(reduction_options_.observer.leap_seconds())},
                                progress)),
          doubts_(progress) {
        if (reduction_options_.system)
            reduction_.emplace(reduction_options_, estimator_, progress);
        head_ = std::string("file,frame,") + encoder_->columns() + (reduction_ ? FrameReduction::kColumns : "") + "\n";
        for (const std::string &note : notes_)
            progress.tell(note);
    }

    void encode_file(const std::string &path);
    void end() {
        doubts_.end([&](const std::string &kind, int64_t count, int64_t) {
            return formatted("%lld of %zu frames ", static_cast<long long>(count), frames_) + kind;
        });
        encoder_->end(progress_);
        if (reduction_)
            reduction_->end(progress_);
    }

  private:
    toliman_status encode(const toliman_image &image, size_t first, size_t count);
    void encode_batch(FrameFile &frames, Batch &batch, const std::string &path);
    void print(FrameFile &frames, size_t number, size_t i, const std::string &path);

    const EncodeOptions &options_;
    Progress &progress_;
    Estimator estimator_;
    Notes notes_;                             // options that differ from the scene
    FrameReductionOptions reduction_options_; // with the defaults of the scene
    std::unique_ptr<Encoder> encoder_;
    std::optional<FrameReduction> reduction_;
    Warnings doubts_;
    // Printed together with the first line: a failure on the first frame leaves standard output empty.
    std::string head_;
    size_t frames_ = 0;
};

// Prints the line of frame `number` of the file, i of the last call of the encoder.
void Encoding::print(FrameFile &frames, size_t number, size_t i, const std::string &path) {
    const std::string place = frames.path() + ": frame " + std::to_string(number);
    for (const Doubt &doubt : encoder_->doubts(i))
        doubts_.warn(doubt.kind, place + ": " + doubt.text + other_width(options_, frames));
    print_stdout(std::exchange(head_, "") + path + "," + std::to_string(number) + "," + encoder_->line(i) +
                 (reduction_ ? reduction_->line(i) : "") + "\n");
    frames_++;
}

toliman_status Encoding::encode(const toliman_image &image, size_t first, size_t count) {
    const toliman_status status = encoder_->encode(image, first, count);
    if (status == TOLIMAN_OK && reduction_)
        reduction_->reduce(*encoder_, count);
    return status;
}

// A batch that fails is repeated frame by frame, so that the frames before the bad one are printed.
void Encoding::encode_batch(FrameFile &frames, Batch &batch, const std::string &path) {
    if (encode(batch.image(0), batch.first(), batch.count()) == TOLIMAN_OK) {
        for (size_t i = 0; i < batch.count(); i++)
            print(frames, batch.first() + i, i, path);
        return;
    }
    for (size_t i = 0; i < batch.count(); i++) {
        const size_t number = batch.first() + i;
        if (encode(batch.image(i), number, 1) != TOLIMAN_OK)
            malformed(frames.path() + ": frame " + std::to_string(number), toliman_last_error());
        print(frames, number, 0, path);
    }
}

void Encoding::encode_file(const std::string &path) {
    const auto file = options_.frames.open(path, estimator_.scene.exposure_s);
    FrameFile &frames = *file;
    for (const std::string &note : frames.notes())
        progress_.warn(note);
    if (frames.rows() != static_cast<size_t>(estimator_.rows) || frames.cols() != static_cast<size_t>(estimator_.cols))
        malformed(frames.path(), "frames of " + shape_text(frames.rows(), frames.cols()) + ": the " +
                                     (estimator_.network ? "weights are" : "scene is") + " for " +
                                     shape_text(estimator_.rows, estimator_.cols));
    encoder_->open(frames);
    Batch batch(frames, path == "-" || !frames.counted());
    for (batch.read(); batch.count() > 0; batch.read()) {
        encode_batch(frames, batch, path);
        batch.rethrow();
        const size_t done = batch.first() + batch.count();
        if (frames.counted())
            progress_.show("encode", static_cast<double>(done) / static_cast<double>(frames.count()));
        else
            progress_.note("encode", std::to_string(done) + " frames");
        stop_if_asked();
    }
}

void check(const EncodeOptions &options) {
    options.estimator_options.check();
    const std::optional<double> &cadence = options.frames.cadence;
    if (cadence && options.estimator_options.fit.empty())
        throw Failure(kExitUsage, formatted("--cadence %g: needs --fit", *cadence));
}

void encode(const EncodeOptions &options, Progress &progress) {
    check(options);
    Encoding encoding(options, progress);
    for (const std::string &path : options.frames.inputs())
        encoding.encode_file(path);
    encoding.end();
}

} // namespace

void add_encode(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "encode");
    auto options = std::make_shared<EncodeOptions>();
    options->estimator_options.add_to(*command);
    options->frames.add_to(*command);
    options->reduction.add_to(*command);
    set_action(*command, context, options, encode);
}

} // namespace cli
