// Tests crafted inputs of the program: endless lines, empty lines, giant dimensions; and inputs that were once read
// incorrectly.
#include <string>

#include "bounds.hpp"
#include "common/failure.hpp"
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

void table(const std::string &path) {
    cli::Progress quiet(cli::Progress::Style::none);
    cli::read_series(path, {}, quiet);
}

using Read = void (*)(const std::string &path);

void costs(const char *what, const std::string &text, size_t model, Read read) {
    static fuzz::MemoryFile file("x.npy");
    file.set(text.data(), text.size());
    within(what, model, [&] { refusal([&] { read(file.path()); }); });
}

void samples(const char *what, const std::string &text, size_t model = 0) {
    costs(what, text, model, table);
}

void past_misreadings() {
    fuzz::MemoryFile file;
    const auto reads = [&](const std::string &text, auto read) {
        file.set(text.data(), text.size());
        return refusal([&] { read(file.path()); });
    };
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

// promise: resources-are-bounded
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
    const auto frames = [](const std::string &path) { cli::open_frames(path); };
    for (const std::string shape : {"16777216, 16384, 16384", "18446744073709551615, 18446744073709551615, 8"})
        costs("frames: giant .npy",
              "\x93NUMPY\x01" + std::string("\0\x76\0", 3) + "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                  shape + "), }" + std::string(60, ' '),
              0, frames);
    past_misreadings();
    return failures != 0;
}
