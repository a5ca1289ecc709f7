// Texts that the program reads: samples as CSV or JSON Lines, and times of headers. The first byte selects which.
#include <cmath>
#include <map>

#include "downlink/frame_times.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"
#include "series/series.hpp"

using namespace fuzz;

namespace {

void read_samples(const std::string &text, const std::vector<std::string> &columns) {
    cli::SampleReader reader(path_of(text), columns, {});
    for (cli::Sample sample = {};;) {
        try {
            if (!reader.next(sample))
                return;
        } catch (const cli::BadLine &) { // reading may continue
            continue;
        }
        require(std::isfinite(sample.t) && std::isfinite(sample.y) && sample.sigma > 0, "an impossible sample");
    }
}

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
    return seeds_of({"s# comment\n1,2\n3,4,\n5,6\n", "st,y,sigma\n1,2,3\n\"4\",5e3,6\n",
                     "s\xef\xbb\xbf{\"t\": 1, \"y\": 2, \"sigma\": 3}\n", "nframe,t,latent,sigma\n0,1,2,3\n1,2,3,4\n",
                     "smjd,y\n60000.5,1\n", "s2028-03-01T12:00:00Z,1\n2028-03-02,2\n",
                     "s{\"t\": \"2028-03-01\", \"y\": 2}\n", "tMJD-AVG=60000.25\nTIMESYS='TAI'\ndays=0.5\n",
                     "tDATE-OBS='2016-12-31T23:59:60.5'\nEXPTIME=2.5E0\n",
                     "tMJD-BEG=57753.99\nXPOSURE=1\nTIMESYS='GPS'\n"});
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const std::string text(reinterpret_cast<const char *>(data) + 1, size - 1);
    try {
        switch (data[0]) {
        case 't':
            read_times(text);
            break;
        case 'n':
            read_samples(text, {"t", "latent", "sigma"});
            break;
        default:
            read_samples(text, {});
        }
    } catch (const cli::Failure &failure) {
        require(failure.code() == cli::kExitInput, failure.what());
    }
    return 0;
}
