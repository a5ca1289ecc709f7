// Arrays of results whose number the caller does not know, as arguments (..., array, capacity, count) of a function.
// *count becomes the number of results. If capacity is smaller, the call fails with Status::capacity and writes nothing
// else; so does the question for the number, with array NULL and capacity 0, unless there are no results.
#pragma once
#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "api/guard.hpp"
#include "api/struct_array.hpp"

namespace toliman::api {

// Each result has `width` numbers.
template <class T> class Output {
  public:
    Output(T *array, const char *name, size_t capacity, size_t *count, size_t width = 1)
        : array_(array), capacity_(capacity), count_(&required(count, "count")) {
        required_array(array, capacity, width * sizeof(T), name);
    }

    // Sets *count. Returns the array, which has at least `found` elements; `what` names them.
    T *resize(size_t found, const char *what) const {
        *count_ = found;
        if (capacity_ < found)
            fail(Status::capacity, "{capacity} = %zu: must be at least %zu, the number of %s", capacity_, found, what);
        return array_;
    }

  private:
    T *array_;
    size_t capacity_;
    size_t *count_;
};

// An array of public structs.
template <class T> class StructOutput {
  public:
    StructOutput(T *array, const char *name, size_t capacity, size_t *count) : output_(array, name, capacity, count) {
        if (capacity > 0)
            structs_.emplace(array, name);
    }

    // Sets *count and writes convert(i), which must not fail, to each element i < found; `what` names them.
    template <class Convert> void write(size_t found, const char *what, Convert convert) const {
        output_.resize(found, what);
        for (size_t i = 0; i < found; i++)
            structs_->put(i, convert(i));
    }

  private:
    Output<T> output_;
    std::optional<StructArray<T>> structs_;
};

// Copies text to a member of a caller's struct: truncated to fit, at the end of a character of UTF-8, and terminated by
// a zero byte.
template <size_t capacity> void put_text(const std::string &text, char (&out)[capacity]) noexcept {
    size_t length = text.size() < capacity ? text.size() : capacity - 1;
    while (length < text.size() && length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80)
        length--;
    text.copy(out, length);
    out[length] = '\0';
}

// Copies values to an array that may be NULL.
template <class Values, class T> void copy_to(T *array, const Values &values) {
    if (array != nullptr)
        std::copy(values.begin(), values.end(), array);
}

// Copies values [rows][cols] to an image.
inline void copy_rows(const double *values, size_t rows, size_t cols, double *image, size_t stride) {
    for (size_t row = 0; row < rows; row++)
        std::copy_n(values + row * cols, cols, image + row * stride);
}

// The same rule for the content of a file, (..., bytes, capacity, needed): the check, and the copy with the check.
inline void check_bytes(size_t size, const void *bytes, size_t capacity, size_t *needed) {
    required(needed, "needed");
    if (capacity > 0)
        required(bytes, "bytes");
    *needed = size;
    if (capacity < size)
        fail(Status::capacity, "{capacity} = %zu: must be at least %zu bytes", capacity, size);
}

inline void deliver_bytes(const std::vector<uint8_t> &content, void *bytes, size_t capacity, size_t *needed) {
    check_bytes(content.size(), bytes, capacity, needed);
    std::memcpy(bytes, content.data(), content.size());
}

} // namespace toliman::api
