// Times of FITS headers, which the program reads.
#include <map>
// promise: parsers-are-safe

#include "common/failure.hpp"
#include "frames/predictions.hpp"
#include "fuzz.hpp"

using namespace fuzz;

namespace {

// A header of lines KEY=VALUE and a table with one column.
class Header final : public cli::FrameFile {
  public:
    explicit Header(const std::string &text) : FrameFile("header") {
        set_axes({3, 1, 1});
        for (size_t at = 0; at < text.size();) {
            const size_t end = std::min(text.find('\n', at), text.size());
            const std::string line = text.substr(at, end - at);
            const size_t sign = line.find('=');
            if (sign != std::string::npos)
                values_[line.substr(0, sign)] = line.substr(sign + 1);
            at = end + 1;
        }
    }
    std::optional<std::string> value_of(const std::string &key) override {
        const auto found = values_.find(key);
        return found != values_.end() ? std::optional(found->second) : std::nullopt;
    }
    std::vector<double> days() override {
        const auto found = values_.find("days");
        if (found == values_.end())
            return {};
        const double step = std::atof(found->second.c_str());
        return {0, step, 2 * step};
    }

  private:
    void load(size_t, void *) override {}
    std::map<std::string, std::string> values_;
};

void read_times(const std::string &text) {
    static const cli::LeapSeconds leap_seconds;
    Header header(text);
    const cli::FrameTimes times(header, 7, 86400.0, leap_seconds);
    require(!times.rule().empty() && times.at(2) - times.at(0) < INT64_MAX / 2, "no time");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return seeds_of(
        {"MJD-AVG=60000.25\nTIMESYS='TAI'\ndays=0.5\n", "DATE-OBS='2016-12-31T23:59:60.5'\nEXPTIME=2.5E0\n",
         "MJD-BEG=57753.99\nXPOSURE=1\nTIMESYS='GPS'\n",
         "DATE-OBS='2028-03-01'\nTIME-OBS='12:00:00'\nDATE-END='2028-061 13:00:00'\nTIMESYS='UTC(NIST)'\n"});
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    try {
        read_times(std::string(reinterpret_cast<const char *>(data), size));
        fuzz::accepted++;
    } catch (const cli::Failure &failure) {
        require(failure.code() == cli::kExitInput, failure.what());
    }
    return 0;
}
