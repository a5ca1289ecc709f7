// The median of numbers.
#pragma once
#include <algorithm>
#include <vector>

namespace cli {

// The mean of the two in the middle, of an even number; 0 of none.
template <class Value> Value median(std::vector<Value> values) {
    std::sort(values.begin(), values.end());
    const size_t n = values.size();
    return n == 0 ? Value() : (values[(n - 1) / 2] + values[n / 2]) / 2;
}

} // namespace cli
