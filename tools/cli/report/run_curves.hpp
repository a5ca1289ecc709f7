// Series, periodograms and training of a `toliman run`.
#pragma once
#include <string>

#include "report/page.hpp"
#include "report/result_file.hpp"

namespace cli {

void add_run_curves(const std::string &folder, const ResultFile &result, Page &page);

// A period of this result, with the decimals of the one found.
std::string period_text(const ResultFile &result, double period);
bool has_signal(const ResultFile &result);
// Whether noise alone hardly has such a peak.
bool is_significant(const ResultFile &result);

} // namespace cli
