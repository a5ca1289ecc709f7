// What a page says of each kind of folder.
#pragma once
#include <string>

#include "common/terminal.hpp"
#include "report/page.hpp"

namespace cli {

void add_run_section(const std::string &folder, Page &page, Progress &progress);        // of `toliman run`
void add_experiment_section(const std::string &folder, Page &page, Progress &progress); // of `toliman experiment`
void add_state_section(const std::string &folder, Page &page, Progress &progress);      // of `toliman track`
void add_bench_section(const std::string &folder, Page &page, Progress &progress);      // of `make bench`

// Files of benches in a folder, sorted; none where there is none.
std::vector<std::string> bench_files(const std::string &folder);

} // namespace cli
