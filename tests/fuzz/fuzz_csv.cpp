// Texts that the program reads: samples as CSV or JSON Lines, clock tables, leap seconds, and times of headers. The
// first byte selects which.
#include <cmath>
#include <map>

#include "downlink/clock_table.hpp"
#include "downlink/frame_times.hpp"
#include "downlink/leap_seconds.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"
#include "series/series.hpp"

using namespace fuzz;

namespace {

const std::string &path_of(const std::string &text) {
    static MemoryFile file;
    file.set(text.data(), text.size());
    return file.path();
}

void read_samples(const std::string &text, const std::vector<std::string> &columns) {
    cli::SampleReader reader(path_of(text), columns);
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

void read_clock(const std::string &text) {
    cli::Progress progress(cli::Progress::Style::none);
    const std::vector<int64_t> clock = cli::read_clock(path_of(text), progress);
    require(!clock.empty() && clock.size() % 2 == 0, "an empty clock");
    for (size_t i = 2; i < clock.size(); i++)
        require(clock[i] > clock[i - 2], "a clock that does not increase");
}

void read_leap_seconds(const std::string &text) {
    const cli::LeapSeconds table(path_of(text));
    for (const int64_t day : {41317, 50000, 60000})
        require(table.seconds_of(day) >= 86399 && table.seconds_of(day) <= 86401, "an impossible day");
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
    void next(double *) override {}
    void skip_next() override {}
    std::map<std::string, std::string> values_;
};

void read_times(const std::string &text) {
    static const cli::LeapSeconds leap_seconds("");
    Header header(text);
    const cli::FrameTimes times(header, 7, 86400.0, leap_seconds);
    require(!times.rule().empty() && times.at(2) - times.at(0) < INT64_MAX / 2, "no time");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds;
    for (const char *text :
         {"s# comment\n1,2\n3,4,\n5,6\n", "st,y,sigma\n1,2,3\n\"4\",5e3,6\n",
          "s\xef\xbb\xbf{\"t\": 1, \"y\": 2, \"sigma\": 3}\n", "nframe,t,latent,sigma\n0,1,2,3\n1,2,3,4\n",
          "ccamera_ns,tai_ns\n1,2 # comment\n1000000001,1000000002\n",
          "l#@ 3928521600\n2272060800 10\n2287785600 11 # 1 Jul 1972\n", "tMJD-AVG=60000.25\nTIMESYS='TAI'\ndays=0.5\n",
          "tDATE-OBS='2016-12-31T23:59:60.5'\nEXPTIME=2.5E0\n", "tMJD-BEG=57753.99\nXPOSURE=1\nTIMESYS='GPS'\n"})
        seeds.push_back(bytes_of(text));
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const std::string text(reinterpret_cast<const char *>(data) + 1, size - 1);
    try {
        switch (data[0]) {
        case 'c':
            read_clock(text);
            break;
        case 'l':
            read_leap_seconds(text);
            break;
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
