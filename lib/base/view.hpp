// Non-owning views of images. Kernels may include it.
#pragma once
#include <cstddef>
#include <cstdint>

namespace toliman {

// rows x cols elements, C order; row r starts at data + r * stride (stride in elements, >= cols).
template <class T> struct ImageView {
    T *data;
    size_t rows, cols, stride;
    T *row(size_t r) const noexcept { return data + r * stride; }
};

} // namespace toliman
