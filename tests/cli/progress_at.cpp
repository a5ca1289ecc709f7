// Shows the progress of the lines of standard input, "SECONDS STAGE FRACTION" or "SECONDS STAGE NOTE", at these times.
#include <iostream>

#include "common/terminal.hpp"

namespace {

std::chrono::duration<double> seconds{0};

cli::Progress::Clock::time_point now() {
    return cli::Progress::Clock::time_point(std::chrono::duration_cast<cli::Progress::Clock::duration>(seconds));
}

} // namespace

int main(int argc, char **) {
    using Style = cli::Progress::Style;
    cli::Progress progress(argc > 1 ? Style::json : Style::automatic, now);
    double at = 0;
    for (std::string stage, word; std::cin >> at >> stage >> word;) {
        seconds = std::chrono::duration<double>(1000 + at);
        if (word.find_first_not_of("0123456789.") == std::string::npos)
            progress.show(stage.c_str(), std::stod(word), "note");
        else
            progress.note(stage.c_str(), word);
    }
}
