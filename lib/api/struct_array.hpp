// An array of structs of a caller whose structs may be smaller than ours: the struct_size of the first element is the
// distance from element to element.
#pragma once
#include <type_traits>

#include "api/guard.hpp"

namespace toliman::api {

template <class T> class StructArray {
  public:
    using Plain = std::remove_const_t<T>;

    StructArray(T *first, const char *name) : bytes_(reinterpret_cast<Byte *>(&required(first, name))) {
        check_struct_size(name, *first);
        size_ = first->struct_size;
    }

    uint32_t size() const noexcept { return size_; }

    // Returns a copy of element i; members that the caller's struct lacks are 0.
    Plain get(size_t i) const noexcept {
        Plain whole = {};
        __builtin_memcpy(&whole, bytes_ + i * size_t{size_}, size_);
        return whole;
    }

    // Copies a struct to element i, truncated to the caller's struct.
    void put(size_t i, Plain whole) const noexcept {
        whole.struct_size = size_;
        __builtin_memcpy(bytes_ + i * size_t{size_}, &whole, size_);
    }

  private:
    using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;

    Byte *bytes_;
    uint32_t size_ = 0;
};

} // namespace toliman::api
