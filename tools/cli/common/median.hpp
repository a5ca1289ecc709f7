// The median of numbers.
#pragma once
#include <algorithm>
#include <vector>

namespace cli {

// The mean of the two in the middle, of an even number; 0 of none.
template <class Value> Value median(std::vector<Value> values) {
    if (values.empty())
        return Value();
    const auto upper = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), upper, values.end());
    const auto lower = values.size() % 2 == 1 ? upper : std::max_element(values.begin(), upper);
    return (*lower + *upper) / 2;
}

} // namespace cli
