// The mission's pair of files: the side file's description of the frames, and their location in the binary. The input
// is the size of the binary (u16), followed by the side file.
#include <algorithm>

#include "common/failure.hpp"
#include "downlink/pair.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"

using namespace fuzz;

namespace {

bool is_name(const std::string &text) {
    return !text.empty() && text.size() <= 64 && text[0] != '.' &&
           std::all_of(text.begin(), text.end(),
                       [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-'; });
}

// Accepts every frame, and counts that each line of the side file is reported once.
class Watch final : public cli::Receiver {
  public:
    Watch(size_t width, size_t bytes) : width_(width), bytes_(bytes) {}
    cli::Arrival &next() override { return arrival_; }
    void take() override {
        const cli::FrameFacts &facts = arrival_.facts;
        require(is_name(facts.session) && is_name(facts.roi), "a name with invalid characters");
        require(facts.rows > 0 && facts.cols > 0 && facts.dropped >= 0, "impossible facts");
        require(arrival_.pixels.size() == facts.rows * facts.cols * width_, "a frame of wrong size");
        taken_ += arrival_.pixels.size();
        require(taken_ <= bytes_, "more frames than the file has");
        reported++;
    }
    void reject(const std::string &, const cli::FrameFacts *facts, const char *, const std::string &why) override {
        require(!why.empty() && (facts == nullptr || is_name(facts->session)), "rejected without a reason");
        reported++;
    }
    void remark(cli::Remark, const std::string &, const std::string &text) override {
        require(!text.empty(), "an empty warning");
    }
    void tell(const char *, const std::string &, const std::string &, bool) override {}
    bool wants(const cli::FrameFacts &) override { return true; }
    void wait() override {}
    size_t reported = 0;

  private:
    cli::Arrival arrival_;
    size_t width_, bytes_, taken_ = 0;
};

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::string text;
    for (const char *line :
         {R"({"frame_id": 7, "timestamp_ns": 1700000000000000001, "host_time": 1.5, "nframes_dropped": 0,)"
          R"( "roi_label": "single_roi", "n_rows": 4, "n_cols": 4, "session_id": "pass-1"})",
          R"({"frame_id":8,"timestamp_ns":-5,"host_time":1e3,"nframes_dropped":2,"roi_label":"r","n_rows":2,)"
          R"("n_cols":8,"session_id":"s"})"})
        text += line + std::string("\n");
    std::vector<Bytes> seeds;
    for (const std::string size : {"\x40", "\x80", "\x21", "\x41"})
        seeds.push_back(bytes_of(size + '\0' + text));
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static MemoryFile side("x_meta.jsonl"), binary("x_frames.bin");
    Source source(data, size);
    const size_t bytes = source.number(2);
    const bool wide = (bytes & 1) != 0;
    const Bytes text = source.rest();
    side.set(text.data(), text.size());
    binary.resize(bytes);
    const auto lines =
        static_cast<size_t>(std::count(text.begin(), text.end(), '\n')) + (text.empty() || text.back() == '\n' ? 0 : 1);
    Watch watch(wide ? 4 : 2, bytes);
    cli::Pair pair(side.path(), {wide, 4, 4});
    try {
        pair.read(watch, false);
        pair.end(watch);
        require(watch.reported == lines, "a line was not reported exactly once");
    } catch (const cli::Failure &failure) {
        require(failure.code() == cli::kExitInput, failure.what());
    }
    return 0;
}
