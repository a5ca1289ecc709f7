// Little-endian byte streams. Every file format is written and read through them, never by copying structs.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/error.hpp"

namespace toliman {

// Writes the lowest `count` bytes of a number, lowest first; returns the address after them.
inline uint8_t *put_number(uint8_t *at, uint64_t value, int count) noexcept {
    for (int i = 0; i < count; i++)
        *at++ = static_cast<uint8_t>(value >> (8 * i));
    return at;
}

// Reads `count` bytes, lowest first, and advances `at`.
inline uint64_t take_number(const uint8_t *&at, int count) noexcept {
    uint64_t value = 0;
    for (int i = 0; i < count; i++)
        value |= static_cast<uint64_t>(*at++) << (8 * i);
    return value;
}

// Reinterprets the bits of a number as another type of the same size.
template <class To, class From> To with_bits(From from) noexcept {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    std::memcpy(&to, &from, sizeof to);
    return to;
}

class ByteWriter {
  public:
    void u8(uint8_t value) { bytes_.push_back(value); }
    void u16(uint16_t value) { put(value, 2); }
    void u32(uint32_t value) { put(value, 4); }
    void u64(uint64_t value) { put(value, 8); }
    void i64(int64_t value) { put(static_cast<uint64_t>(value), 8); }
    void f32(float value) { u32(with_bits<uint32_t>(value)); }
    void f64(double value) { u64(with_bits<uint64_t>(value)); }
    void raw(const void *data, size_t size) {
        const auto *first = static_cast<const uint8_t *>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }
    const std::vector<uint8_t> &bytes() const noexcept { return bytes_; }
    std::vector<uint8_t> take() noexcept { return std::move(bytes_); }

  private:
    void put(uint64_t value, int count) {
        uint8_t bytes[8];
        bytes_.insert(bytes_.end(), bytes, put_number(bytes, value, count));
    }
    std::vector<uint8_t> bytes_;
};

// Reads within bounds. Reading past the end is Status::format; the message begins with `kind`.
class ByteReader {
  public:
    ByteReader(const void *data, size_t size, const char *kind) noexcept
        : next_(static_cast<const uint8_t *>(data)), left_(size), kind_(kind) {}
    uint8_t u8() { return static_cast<uint8_t>(get(1)); }
    uint16_t u16() { return static_cast<uint16_t>(get(2)); }
    uint32_t u32() { return static_cast<uint32_t>(get(4)); }
    uint64_t u64() { return get(8); }
    int64_t i64() { return static_cast<int64_t>(get(8)); }
    float f32() { return with_bits<float>(u32()); }
    double f64() { return with_bits<double>(u64()); }
    const uint8_t *raw(size_t size) {
        need(size);
        const uint8_t *data = next_;
        next_ += size;
        left_ -= size;
        return data;
    }
    size_t left() const noexcept { return left_; }

  private:
    void need(size_t size) const {
        if (size > left_)
            fail(Status::format, "%s: truncated: %zu more bytes are needed, %zu are left", kind_, size, left_);
    }
    uint64_t get(int count) {
        const uint8_t *data = raw(static_cast<size_t>(count));
        return take_number(data, count);
    }
    const uint8_t *next_;
    size_t left_;
    const char *kind_;
};

} // namespace toliman
