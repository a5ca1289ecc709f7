// The mission's pair of files. The input is the size of the file of pixels (2 bytes; its last two bits are the pixel
// type: u16, u32, or found in the files), the part of both files that a growing pair has at first (2 bytes), and the
// side file.
#include <algorithm>
#include <cctype>
#include <memory>
#include <utility>
// promises: damaged-lines-are-events, parsers-are-safe

#include <toliman/toliman.hpp>

#include "fuzz.hpp"
#include "memory_file.hpp"

using namespace fuzz;

namespace {

bool is_name(const std::string &text) {
    return !text.empty() && text.size() <= 64 && text[0] != '.' &&
           std::all_of(text.begin(), text.end(),
                       [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-'; });
}

struct Input {
    int32_t pixel; // 0: found
    size_t pixel_bytes;
    Bytes text;
};

// Which lines of a text are blank. An unterminated last line counts only if the file is complete.
std::vector<bool> blank_lines(const Bytes &text, bool is_complete) {
    std::vector<bool> blank;
    bool now = true, any = false;
    for (const uint8_t byte : text) {
        any = byte != '\n';
        if (!any)
            blank.push_back(std::exchange(now, true));
        else
            now = now && (byte == ' ' || byte == '\t' || byte == '\r');
    }
    if (any && is_complete)
        blank.push_back(now);
    return blank;
}

// Counts the lines that are reported, in their order; blank ones are not.
class Watch {
  public:
    Watch(const Input &input, const std::string &path, uint32_t flags)
        : input_(input), blank_(blank_lines(input.text, flags == 0)) {
        auto options = toliman::sized<toliman_ingest_options>();
        options.flags = flags;
        options.pixel = input.pixel;
        options.rows = options.cols = 4;
        options.exposure_s = 1;
        toliman_ingest *made = nullptr;
        require(toliman_ingest_create(path.c_str(), &options, &made) == TOLIMAN_OK, "a pair cannot be opened");
        ingest_.reset(made);
    }

    // Reads up to NOTHING. False for a file that cannot be of such a pair.
    bool read() {
        for (;;) {
            auto frame = toliman::sized<toliman_frame>();
            auto event = toliman::sized<toliman_ingest_event>();
            const toliman_status status = toliman_ingest_next(ingest_.get(), &frame, &event);
            require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT, toliman_last_error());
            if (status != TOLIMAN_OK)
                return false;
            if (event.event == TOLIMAN_INGEST_EVENT_NOTHING)
                return true;
            take(frame, event);
        }
    }
    void finish() { require(toliman_ingest_finish(ingest_.get()) == TOLIMAN_OK, "finish"); }
    // Whether each line that is not blank was reported.
    bool is_at_end() noexcept {
        skip_blank();
        return lines_ == blank_.size();
    }

  private:
    void skip_blank() noexcept {
        while (lines_ < blank_.size() && blank_[lines_])
            lines_++;
    }
    void take(const toliman_frame &frame, const toliman_ingest_event &event) {
        skip_blank();
        if (event.event == TOLIMAN_INGEST_EVENT_WARNING)
            return require(event.text[0] != 0 && event.line <= static_cast<int64_t>(lines_) + 1, "a stray warning");
        require(event.line == static_cast<int64_t>(++lines_), "a line is not reported exactly once");
        require(event.has_key == 0 || (is_name(frame.session) && is_name(frame.roi)), "an invalid name");
        if (event.event == TOLIMAN_INGEST_EVENT_DAMAGE)
            return require(event.text[0] != 0, "damage without a reason");
        fuzz::accepted++;
        require(frame.pixel == input_.pixel || input_.pixel == 0, "another pixel type");
        require(frame.rows > 0 && frame.cols > 0 && frame.dropped >= 0, "an impossible frame");
        const auto bytes = static_cast<size_t>(frame.rows * frame.cols) * (frame.pixel == TOLIMAN_PIXEL_U32 ? 4 : 2);
        taken_ += bytes;
        require(taken_ <= input_.pixel_bytes, "more frames than the file has");
        const auto *const pixels = static_cast<const uint8_t *>(frame.pixels);
        require(std::all_of(pixels, pixels + bytes, [](uint8_t byte) { return byte == 0; }), "wrong pixels");
        require((frame.intervals != nullptr) == (frame.interval_count > 0), "intervals without their number");
        double before = 0;
        for (size_t i = 0; i < 2 * frame.interval_count; before = frame.intervals[i++])
            require(frame.intervals[i] >= before && frame.intervals[i] <= frame.exposure_s, "impossible intervals");
    }

    struct Destroy {
        void operator()(toliman_ingest *ingest) const noexcept { toliman_ingest_destroy(ingest); }
    };
    std::unique_ptr<toliman_ingest, Destroy> ingest_;
    const Input &input_;
    const std::vector<bool> blank_;
    size_t lines_ = 0, taken_ = 0;
};

void read_complete(const Input &input, MemoryFile &side, MemoryFile &pixels) {
    side.set(input.text.data(), input.text.size());
    pixels.resize(input.pixel_bytes);
    Watch watch(input, side.path(), 0);
    if (watch.read())
        require(watch.is_at_end(), "a line of a complete file is missing");
}

// A first part of both files, then all of them.
void read_growing(const Input &input, size_t part, MemoryFile &side, MemoryFile &pixels) {
    const size_t first = std::min(part, input.text.size()), first_pixels = std::min(part, input.pixel_bytes);
    side.set(input.text.data(), first);
    pixels.resize(0);
    pixels.resize(first_pixels);
    Watch watch(input, side.path(), TOLIMAN_INGEST_GROWING);
    watch.read();
    if (first < input.text.size())
        side.set(input.text.data(), input.text.size());
    if (first_pixels < input.pixel_bytes)
        pixels.resize(input.pixel_bytes);
    if (!watch.read() || !watch.read())
        return;
    watch.finish();
    require(watch.read() && watch.is_at_end(), "a line of a growing file is missing");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::string text;
    for (const char *line :
         {R"({"frame_id": 7, "timestamp_ns": 1700000000000000001, "host_time": 1.5, "nframes_dropped": 0,)"
          R"( "roi_label": "single_roi", "n_rows": 4, "n_cols": 4, "session_id": "pass-1"})",
          R"({"frame_id":8,"timestamp_ns":-5,"host_time":1e3,"nframes_dropped":2,"roi_label":"r","n_rows":2,)"
          R"("n_cols":8,"session_id":"s","dtype":"u32le","on_target_s":[0,0.25,0.5,1]})"})
        text += line + std::string("\n");
    std::vector<Bytes> seeds;
    for (const std::string size : {"\x40", "\x80", "\x21", "\x41", "\x42", "\x82"})
        for (const std::string part : {"\x20", "\xc8"})
            seeds.push_back(bytes_of(size + '\0' + part + '\0' + text));
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static MemoryFile side("x_meta.jsonl"), pixels("x_frames.bin");
    Source source(data, size);
    const size_t bytes = source.number(2), part = source.number(2);
    const int32_t types[] = {TOLIMAN_PIXEL_U16, TOLIMAN_PIXEL_U32, 0, 0};
    const Input input = {types[bytes & 3], bytes, source.rest()};
    read_complete(input, side, pixels);
    read_growing(input, part, side, pixels);
    return 0;
}
