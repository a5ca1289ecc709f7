// Method: a value is a possible mark if its digits are nines (-9999, 99.9, 999.99), if it is a limit of 16-bit
// integers, or at least 1e20. It is one if it is farther from the other values than three times their range, or outside
// of it and repeated. Extremes and counts of the others suffice, so that memory does not grow with the series.
#include "ingest/missing_marks.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace toliman::ingest {

namespace {

constexpr double kHuge = 1e20, kFar = 3; // ranges of the other values
constexpr int64_t kFewestOthers = 5;     // values
constexpr size_t kMostMarks = 16, kMostLines = 3;

// Whether all digits are nines: at least two before the point, or three.
bool has_nines(double value) {
    const double size = std::fabs(value);
    double power = 10;
    while (power <= size && power < kHuge)
        power *= 10;
    if (!(size >= 0.98 * power)) // most numbers
        return false;
    char digits[40];
    print_text(digits, sizeof digits, "%.10g", size);
    const std::string text = digits;
    const auto nines = static_cast<size_t>(std::count(text.begin(), text.end(), '9'));
    const size_t point = text.find('.');
    const bool only = nines + (point != text.npos ? 1 : 0) == text.size();
    return only && (std::min(point, text.size()) >= 2 || nines >= 3);
}

bool is_possible(double value, bool of_time) {
    return (std::fabs(value) >= kHuge && !of_time) || value == -32768 || value == 32767 || has_nines(value);
}

} // namespace

void MissingMarks::add(size_t index, double value, int64_t line) {
    Column &column = columns_[index];
    if (!is_possible(value, index == 0)) {
        column.least = column.count == 0 ? value : std::min(column.least, value);
        column.largest = column.count == 0 ? value : std::max(column.largest, value);
        column.count++;
        return;
    }
    auto mark = std::find_if(column.marks.begin(), column.marks.end(), [&](const Mark &m) { return m.value == value; });
    if (mark == column.marks.end() && column.marks.size() == kMostMarks)
        return;
    if (mark == column.marks.end())
        mark = column.marks.insert(mark, {value, 0, {}});
    mark->count++;
    if (mark->lines.size() < kMostLines)
        mark->lines.push_back(line);
}

std::string MissingMarks::found(const std::string &what, int64_t before) const {
    constexpr const char *kNames[] = {"t", "y", "sigma"};
    for (size_t i = 0; i < columns_.size(); i++)
        for (const Mark &mark : columns_[i].marks) {
            const Column &column = columns_[i];
            const double distance = std::max(column.least - mark.value, mark.value - column.largest);
            const double range = column.largest - column.least;
            const bool is_mark = distance > kFar * range || (distance > 0 && mark.count > 1);
            if (column.count < kFewestOthers || !is_mark)
                continue;
            char number[40];
            print_text(number, sizeof number, "%.10g", mark.value);
            std::string text = std::string(kNames[i]) + " = " + number + " on " + what + (mark.count > 1 ? "s " : " ");
            for (size_t k = 0; k < mark.lines.size(); k++)
                text += (k > 0 ? ", " : "") + std::to_string(mark.lines[k] - before);
            const int64_t more = mark.count - static_cast<int64_t>(mark.lines.size());
            return text + (more > 0 ? " and " + std::to_string(more) + " more" : "");
        }
    return "";
}

} // namespace toliman::ingest
