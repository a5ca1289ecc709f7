// Arrays of structs of a caller, who may know fewer members: they step by the size that the first element tells.
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

    // A copy, in which members that the caller does not know are 0.
    Plain get(size_t i) const noexcept {
        Plain whole = {};
        __builtin_memcpy(&whole, bytes_ + i * size_t{size_}, size_);
        return whole;
    }

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
