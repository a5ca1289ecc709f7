// Tests crafted inputs of the program: endless lines, empty lines, giant dimensions; and inputs that were once read
// incorrectly.
#include <string>

#include "bounds.hpp"
#include "common/failure.hpp"
#include "downlink/side_file.hpp"
#include "frames/frames_in.hpp"
#include "memory_file.hpp"
#include "series/series.hpp"

using namespace bounds;

namespace {

std::string repeated(const std::string &text, size_t size = kMiB) {
    std::string all;
    while (all.size() + text.size() <= size)
        all += text;
    return all;
}

template <class Work> std::string refusal(Work work) {
    try {
        work();
    } catch (const cli::Failure &failure) {
        return failure.what();
    }
    return "";
}

using Read = void (*)(const std::string &path);

void costs(const char *what, const std::string &text, size_t model, Read read) {
    static fuzz::MemoryFile file("x.npy");
    file.set(text.data(), text.size());
    within(what, model, [&] { refusal([&] { read(file.path()); }); });
}

void samples(const char *what, const std::string &text, size_t model = 0) {
    costs(what, text, model, [](const std::string &path) { cli::read_series(path); });
}

void sides(const char *what, const std::string &text) {
    costs(what, text, text.size(), [](const std::string &path) { cli::read_side_file(path, false); });
}

std::string side_line(const std::string &roi, const std::string &extra) {
    return R"({"roi_label": ")" + roi + R"(", "frame_id": 9007199254740993, "timestamp_ns" : 2, "host_time": 3,)" +
           R"( "nframes_dropped": 4, "n_rows": 5, "n_cols": 6, "session_id": "s")" + extra + "}";
}

void past_misreadings() {
    const cli::SideLine line = cli::read_side_line(side_line("frame_id", ""));
    expect(line.why.empty() && line.facts.id == 9007199254740993, "a region by the name of a key is refused");
    expect(!cli::read_side_line(side_line("r", std::string(5000, ' '))).why.empty(), "a long line of a side file");
    fuzz::MemoryFile file;
    const auto reads = [&](const std::string &text, auto read) {
        file.set(text.data(), text.size());
        return refusal([&] { read(file.path()); });
    };
    const auto table = [](const std::string &path) { cli::read_series(path); };
    expect(reads(std::string("{\"t\":1,\"y\":2}\0x\n", 16), table).find("not a JSON object") != std::string::npos,
           "text after a zero byte");
    expect(reads("1,2\n" + std::string(70000, '3') + ",4\n", table).find(":2: is longer than 65536 bytes") !=
               std::string::npos,
           "a long line of samples");
    const auto longest = [](size_t bytes) { return "1,2\n" + std::string(bytes - 3, ' ') + "3,4\n5,6\n7,8\n"; };
    expect(reads(longest(65536), table).empty() && !reads(longest(65537), table).empty(),
           "the longest line of samples");
}

} // namespace

int main() {
    samples("samples: one line of commas", repeated(","));
    samples("samples: commas", repeated(repeated(",", 65000) + "\n"));
    samples("samples: one deep object", repeated("{\"t\":"));
    samples("samples: one long object", "{\"t\":[" + repeated("0,", kMiB - 8) + "0]}");
    samples("samples: objects of nothing", repeated("{\"t\":[" + repeated("0,", 60000) + "0]}\n"));
    samples("samples: empty lines", repeated("\n"));
    samples("samples: zero bytes", std::string(kMiB, '\0'));
    samples("samples: samples", repeated("1,22\n"), kMiB / 5 * 16);
    samples("samples: .npy of 2^60",
            "\x93NUMPY\x01" + std::string("\0\x76\0", 3) +
                "{'descr': '<f8', 'fortran_order': False, 'shape': (1152921504606846976, 2), }" + std::string(47, ' '));
    sides("side file: empty lines", repeated("\n"));
    sides("side file: one line", repeated("["));
    sides("side file: one object", "{" + repeated("\"a\":1,"));
    sides("side file: small objects", repeated("{}\n"));
    sides("side file: frames", repeated(side_line("r", "") + "\n"));
    const auto frames = [](const std::string &path) { cli::open_frames(path); };
    for (const std::string shape : {"16777216, 16384, 16384", "18446744073709551615, 18446744073709551615, 8"})
        costs("frames: giant .npy",
              "\x93NUMPY\x01" + std::string("\0\x76\0", 3) + "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                  shape + "), }" + std::string(60, ' '),
              0, frames);
    past_misreadings();
    return failures != 0;
}
